/* Validation of a blob before its use: SPEC.md, "Requirements". All readers
 * check its section table and CRCs, and all fields that could lead to access
 * out of bounds. rg_blob_open() checks all other limits as well. */
#ifndef RAYGRID_BLOB_CHECKS_H
#define RAYGRID_BLOB_CHECKS_H

#include <stdint.h>

#include "bytes.h"
#include "rg_blob.h"
#include "wide_multiply.h"

typedef struct rg_section {
  const uint8_t* bytes; /* NULL: no such section */
  uint32_t size;
} rg_section;

/* The last section of each type. */
typedef struct rg_sections {
  rg_section of[RG_NUM_SECTION_TYPES];
} rg_sections;

/* Checks the address (not NULL), header, section table and the CRCs of all
 * sections. If RG_OK, every section is inside the blob and not shorter than its
 * fields. */
rg_status rg_check_table(const uint8_t* bytes, uint32_t num_bytes,
                         rg_sections* sections);

/* Returns the index-th entry of a type in a checked section table, or NULL. */
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

/* Returns the camera section, which a checked table contains. */
static inline const uint8_t* rg_find_identity(const uint8_t* bytes) {
  const uint8_t* const entry = rg_find_entry(bytes, RG_SECTION_CAMERA, 0);
  return bytes + rg_load_u32(entry + RG_ENTRY_OFFSET);
}

/* Returns the camera's image size: width, and height in the upper half. */
static inline uint32_t rg_camera_size(const uint8_t* bytes) {
  return rg_load_u32(rg_find_identity(bytes) + RG_CAMERA_WIDTH);
}

/* Returns a mode by its 1-based number, or NULL if the blob lacks it. */
static inline const uint8_t* rg_find_mode(const uint8_t* bytes,
                                          uint32_t number) {
  const uint8_t* const entry = rg_find_entry(bytes, RG_SECTION_MODES, 0);
  if (!entry || number - 1 >= rg_load_u32(entry + RG_ENTRY_SIZE) / RG_MODE_SIZE)
    return 0;
  return bytes + rg_load_u32(entry + RG_ENTRY_OFFSET) +
         (number - 1) * RG_MODE_SIZE;
}

/* Whether scale = floor(cells 2^48 / span): cells 2^48 - scale span is at least
 * 0 and less than span. */
static inline int rg_is_scale(uint32_t scale, uint32_t cells, uint32_t span) {
  uint32_t low;
  uint32_t high = rg_multiply_unsigned(scale, span, &low);
  if (low != 0) ++high; /* borrow */
  return high == cells << 16 && 0u - low < span;
}

/* Checks that a section's arrays start after its fields and fill the rest.
 *
 * data_offset  address of the field */
rg_status rg_check_extent(const uint8_t* data_offset, uint32_t size,
                          uint32_t fields_size, uint32_t data_size);

/* Returns the bytes of a bit mask, padded to words. */
static inline uint32_t rg_mask_size(uint32_t num_bits) {
  return (num_bits + 31) / 32 * 4;
}

/* Checks a central or inverse grid; RG_OK for NULL. */
rg_status rg_check_grid(const uint8_t* section, uint32_t size,
                        uint32_t max_fraction_bits);

/* Checks line points; RG_OK for NULL. grid: the blob's checked grid. */
rg_status rg_check_line_points(const uint8_t* section, uint32_t size,
                               const uint8_t* grid);

/* Returns the size of a table's source: width, and height in the upper half.
 * The section may be unchecked.
 *
 * camera_size  size of the camera's images, likewise */
static inline uint32_t rg_source_size(const uint8_t* section, uint32_t size,
                                      uint32_t camera_size) {
  return size >= RG_VIEW_FIELDS_SIZE && rg_has_view(section)
             ? rg_load_u32(section + RG_VIEW_SOURCE_WIDTH)
             : camera_size;
}

/* Checks a remap table, except for its vertices. */
rg_status rg_check_remap(const uint8_t* section, uint32_t size,
                         uint32_t source_size);

/* Checks the vertices of a checked table: its own, or those in a sample. */
rg_status rg_check_vertices(const uint8_t* section, const uint8_t* vertices);

/* Checks the line delay section. */
rg_status rg_check_row_time(const uint8_t* section, uint32_t size);

#endif /* RAYGRID_BLOB_CHECKS_H */
