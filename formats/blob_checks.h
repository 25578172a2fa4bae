/* Checks of a blob before its use: SPEC.md, "Requirements". All readers check
 * its table and CRCs, and of each section what keeps its use within its bounds.
 * rg_blob_open() checks the rest as well. */
#ifndef RAYGRID_BLOB_CHECKS_H
#define RAYGRID_BLOB_CHECKS_H

#include <stdint.h>

#include "bytes.h"
#include "rg_blob.h"
#include "wide_multiply.h"

typedef struct rg_section {
  const uint8_t* bytes; /* NULL: there is none */
  uint32_t size;
} rg_section;

/* The last one of each type. */
typedef struct rg_sections {
  rg_section of[RG_NUM_SECTION_TYPES];
} rg_sections;

/* Address (not NULL), header, section table, and the CRCs of all sections.
 * After that every section lies inside the blob and is as long as its fields.
 */
rg_status rg_check_table(const uint8_t* bytes, uint32_t num_bytes,
                         rg_sections* sections);

/* The index-th entry of a type in a section table that was checked, or NULL. */
static inline const uint8_t* rg_find_entry(const uint8_t* bytes, uint32_t type,
                                           uint32_t index) {
  const uint8_t* entry = bytes + RG_HEADER_SIZE - RG_SECTION_ENTRY_SIZE;
  uint32_t rest = rg_load_u16(bytes + RG_HEADER_SECTION_COUNT); /* at least 1 */
  do {
    entry += RG_SECTION_ENTRY_SIZE;
    if (rg_load_u16(entry + RG_ENTRY_TYPE) == type) {
      if (index == 0) return entry;
      --index;
    }
  } while (--rest != 0);
  return 0;
}

/* The camera section. The table was checked, so that there is one. */
static inline const uint8_t* rg_find_identity(const uint8_t* bytes) {
  const uint8_t* const entry = rg_find_entry(bytes, RG_SECTION_CAMERA, 0);
  return bytes + rg_load_u32(entry + RG_ENTRY_OFFSET);
}

/* The size of the camera's images: width, and height times 2^16. */
static inline uint32_t rg_camera_size(const uint8_t* bytes) {
  return rg_load_u32(rg_find_identity(bytes) + RG_CAMERA_WIDTH);
}

/* A mode by its number, counted from 1, or NULL if the blob lacks it. */
static inline const uint8_t* rg_find_mode(const uint8_t* bytes,
                                          uint32_t number) {
  const uint8_t* const entry = rg_find_entry(bytes, RG_SECTION_MODES, 0);
  if (!entry || number - 1 >= rg_load_u32(entry + RG_ENTRY_SIZE) / RG_MODE_SIZE)
    return 0;
  return bytes + rg_load_u32(entry + RG_ENTRY_OFFSET) +
         (number - 1) * RG_MODE_SIZE;
}

/* scale = floor(cells 2^48 / span): cells 2^48 - scale span is at least 0 and
 * less than span. */
static inline int rg_is_scale(uint32_t scale, uint32_t cells, uint32_t span) {
  uint32_t low;
  uint32_t high = rg_multiply_unsigned(scale, span, &low);
  if (low != 0) ++high; /* borrowed */
  return high == cells << 16 && 0u - low < span;
}

/* A section's arrays start behind its fields and fill it to the end.
 *
 * data_offset  the field */
rg_status rg_check_extent(const uint8_t* data_offset, uint32_t size,
                          uint32_t fields_size, uint32_t data_size);

/* Bytes of one bit for each of so many, padded to words. */
static inline uint32_t rg_mask_size(uint32_t num_bits) {
  return (num_bits + 31) / 32 * 4;
}

/* A central or inverse grid; NULL has no fault. */
rg_status rg_check_grid(const uint8_t* section, uint32_t size,
                        uint32_t max_fraction_bits);

/* NULL has no fault. grid: that of the blob, checked. */
rg_status rg_check_line_points(const uint8_t* section, uint32_t size,
                               const uint8_t* grid);

/* The size of a table's source: width, and height times 2^16. The section need
 * not be checked.
 *
 * camera_size  that of the camera's images */
static inline uint32_t rg_source_size(const uint8_t* section, uint32_t size,
                                      uint32_t camera_size) {
  return size >= RG_VIEW_FIELDS_SIZE && rg_has_view(section)
             ? rg_load_u32(section + RG_VIEW_SOURCE_WIDTH)
             : camera_size;
}

/* A table, but for its vertices. */
rg_status rg_check_remap(const uint8_t* section, uint32_t size,
                         uint32_t source_size);

/* Those of a table that was checked: its own, or their like in a knot. */
rg_status rg_check_vertices(const uint8_t* section, const uint8_t* vertices);

/* Checks the row time section. */
rg_status rg_check_row_time(const uint8_t* section, uint32_t size);

#endif /* RAYGRID_BLOB_CHECKS_H */
