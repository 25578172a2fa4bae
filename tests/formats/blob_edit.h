/* Blobs altered or put together for tests, with CRCs that hold. */
#ifndef RAYGRID_BLOB_EDIT_H
#define RAYGRID_BLOB_EDIT_H

#include <stdint.h>

#include "rg_blob.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct blob_section {
  uint16_t type, flags;
  const uint8_t* bytes;
  uint32_t size;
} blob_section;

/* Writes header, table and sections; returns the size of the blob. */
uint32_t assemble_blob(const blob_section* sections, uint32_t num_sections,
                       uint8_t* blob);

/* The k-th section of a blob, in place. */
blob_section section_of(const uint8_t* blob, uint32_t k);

/* Recomputes each CRC whose bytes lie inside the blob. */
void repair_crcs(uint8_t* blob, uint32_t size);

/* Opens a copy of the bytes in a block of exactly that size, so that a
 * sanitizer sees what is read beyond. */
rg_status open_copy(const uint8_t* bytes, uint32_t size);

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_BLOB_EDIT_H */
