/* What readers check before they use a blob: all of them its table and CRCs,
 * and of each section what keeps its use within its bounds; rg_blob_open() the
 * rest as well. SPEC.md, "Duties". */
#ifndef RAYGRID_BLOB_CHECKS_H
#define RAYGRID_BLOB_CHECKS_H

#include <stdint.h>

#include "rg_blob.h"
#include "wide_multiply.h"

/* 0, or the status of a fault times -1: small constants make short code. */
typedef int rg_fault;

/* Compilers would write a short loop out, or call memset for it. */
#if defined(__GNUC__) && defined(__OPTIMIZE__)
#define RG_KEEP_LOOP(index) __asm__("" : "+r"(index))
#else
#define RG_KEEP_LOOP(index) ((void)(index))
#endif

/* Where the table's last entry of each type is, or NULL. */
typedef struct rg_entries {
  const uint8_t* of[RG_NUM_SECTION_TYPES];
} rg_entries;

/* Address, header, section table, and the CRCs of all sections. After that
 * every section lies inside the blob and is as long as its fields. */
rg_fault rg_check_table(const uint8_t* bytes, uint32_t num_bytes,
                        rg_entries* entries);

/* The index-th entry of a type in a section table that was checked, or NULL. */
const uint8_t* rg_find_entry(const uint8_t* bytes, uint32_t type,
                             uint32_t index);

/* scale = floor(cells 2^48 / span): cells 2^48 - scale span is at least 0 and
 * less than span. */
static inline int rg_is_scale(uint32_t scale, uint32_t cells, uint32_t span) {
  uint32_t low;
  const uint32_t high = rg_multiply_unsigned(scale, span, &low);
  const uint64_t product = ((uint64_t)high << 32) | low;
  return ((uint64_t)cells << 48) - product < span;
}

/* The section's arrays start behind its fields and fill it to the end. */
rg_fault rg_check_extent(uint32_t size, uint32_t data_offset,
                         uint32_t fields_size, uint32_t data_size);

/* Bytes of one bit for each of so many, padded to words. */
static inline uint32_t rg_mask_size(uint32_t num_bits) {
  return (num_bits + 31) / 32 * 4;
}

/* A central or inverse grid. */
rg_fault rg_check_grid(const uint8_t* section, uint32_t size,
                       uint32_t max_fraction_bits);

/* grid: that of the blob, checked. */
rg_fault rg_check_line_points(const uint8_t* section, uint32_t size,
                              const uint8_t* grid);

/* A table for source images of a size, but for its vertices. */
rg_fault rg_check_remap(const uint8_t* section, uint32_t size, uint32_t width,
                        uint32_t height);

/* Those of a table that was checked. */
rg_fault rg_check_vertices(const uint8_t* section);

#endif /* RAYGRID_BLOB_CHECKS_H */
