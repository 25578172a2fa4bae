/* The header, the section table, and what is the same in all sections. */
#include "blob_checks.h"
#include "bytes.h"
#include "crc32.h"
#include "rg_blob.h"

/* Magic, version, sizes, and the CRC over header and section table. */
static rg_status check_header(const uint8_t* bytes, uint32_t num_bytes) {
  if (num_bytes < RG_HEADER_SIZE) return RG_ERR_TRUNCATED;
  if (rg_load_u32(bytes) != 0x47594152u || rg_load_u32(bytes + 4) != 0x444952u)
    return RG_ERR_MAGIC; /* "RAYG", "RID\0" */
  if (rg_load_u16(bytes + 8) != RG_FORMAT_MAJOR) return RG_ERR_VERSION;

  const uint32_t total_size = rg_load_u32(bytes + 12);
  const uint32_t num_sections = rg_load_u16(bytes + 16);
  const uint32_t table_size = num_sections * RG_SECTION_ENTRY_SIZE;
  if (total_size > num_bytes) return RG_ERR_TRUNCATED;
  if (total_size % 4 != 0 || rg_load_u16(bytes + 18) != RG_HEADER_SIZE ||
      num_sections - 1 >= RG_MAX_SECTIONS ||
      RG_HEADER_SIZE + table_size > total_size)
    return RG_ERR_HEADER;

  const uint32_t crc = rg_crc32(rg_crc32(0, bytes, RG_HEADER_SIZE - 4),
                                bytes + RG_HEADER_SIZE, table_size);
  if (crc != rg_load_u32(bytes + 28)) return RG_ERR_HEADER_CRC;
  if ((rg_load_u32(bytes + 20) | rg_load_u32(bytes + 24)) != 0)
    return RG_ERR_RESERVED;
  return RG_OK;
}

/* Bytes of the fields of each type of section; 0: unknown. A table, since
 * Armv6-M compilers would call their library for a switch. */
static const uint8_t kFieldsSizes[] = {0,
                                       RG_CAMERA_SIZE,
                                       RG_GRID_FIELDS_SIZE,
                                       RG_REMAP_FIELDS_SIZE,
                                       RG_QUALITY_SIZE,
                                       RG_LINE_POINTS_FIELDS_SIZE,
                                       RG_MASK_FIELDS_SIZE,
                                       RG_UNCERTAINTY_FIELDS_SIZE,
                                       0,
                                       RG_START_FIELDS_SIZE};

#define CRITICAL_TYPES                                       \
  (1u << RG_SECTION_CAMERA | 1u << RG_SECTION_CENTRAL_GRID | \
   1u << RG_SECTION_LINE_POINTS)

/* What an entry of the table says of its section, but for its place. */
static rg_status check_entry(const uint8_t* bytes, const uint8_t* entry) {
  const uint8_t* const section = bytes + rg_load_u32(entry + 4);
  const uint32_t size = rg_load_u32(entry + 8);
  const uint32_t type = rg_load_u16(entry), flags = rg_load_u16(entry + 2);
  if (rg_crc32(0, section, size) != rg_load_u32(entry + 12))
    return RG_ERR_SECTION_CRC;
  if (flags > RG_SECTION_CRITICAL) return RG_ERR_SECTION_FLAGS;
  const uint32_t fields_size =
      type < sizeof(kFieldsSizes) ? kFieldsSizes[type] : 0;
  if (fields_size == 0) return flags != 0 ? RG_ERR_SECTION_UNKNOWN : RG_OK;
  if (flags != (CRITICAL_TYPES >> type & 1u)) return RG_ERR_SECTION_FLAGS;
  if (type != RG_SECTION_REMAP && rg_find_section(bytes, type, 0) != section)
    return RG_ERR_SECTION_DUPLICATE;
  return size < fields_size ? RG_ERR_SECTION_SIZE : RG_OK;
}

rg_status rg_blob_check(const void* blob, uint32_t num_bytes) {
  const uint8_t* const bytes = (const uint8_t*)blob;
  if (!bytes) return RG_ERR_ARGUMENT;
  if ((uintptr_t)blob % 4 != 0) return RG_ERR_MISALIGNED;
  rg_status status = check_header(bytes, num_bytes);
  if (status != RG_OK) return status;

  /* The sections tile the blob, in the order of the table. */
  const uint32_t total_size = rg_load_u32(bytes + 12);
  uint32_t end =
      RG_HEADER_SIZE + rg_load_u16(bytes + 16) * RG_SECTION_ENTRY_SIZE;
  const uint8_t* const table = bytes + RG_HEADER_SIZE;
  const uint8_t* const table_end = bytes + end;
  for (const uint8_t* entry = table; entry != table_end;
       entry += RG_SECTION_ENTRY_SIZE) {
    const uint32_t size = rg_load_u32(entry + 8);
    if (rg_load_u32(entry + 4) != end || size == 0 || size % 4 != 0 ||
        size > total_size - end)
      return RG_ERR_SECTION_TABLE;
    end += size;
    status = check_entry(bytes, entry);
    if (status != RG_OK) return status;
  }
  if (end != total_size) return RG_ERR_SECTION_TABLE;

  const uint8_t* const camera = rg_find_section(bytes, RG_SECTION_CAMERA, 0);
  const uint8_t* const grid =
      rg_find_section(bytes, RG_SECTION_CENTRAL_GRID, 0);
  if (!camera || !grid) return RG_ERR_SECTION_MISSING;
  for (const uint8_t* entry = table; entry != table_end && status == RG_OK;
       entry += RG_SECTION_ENTRY_SIZE)
    status =
        rg_check_section(rg_load_u16(entry), bytes + rg_load_u32(entry + 4),
                         rg_load_u32(entry + 8), camera, grid);
  return status;
}

const uint8_t* rg_find_section(const uint8_t* bytes, uint32_t type,
                               uint32_t index) {
  const uint8_t* entry = bytes + RG_HEADER_SIZE;
  const uint8_t* const end =
      entry + rg_load_u16(bytes + 16) * RG_SECTION_ENTRY_SIZE;
  for (; entry < end; entry += RG_SECTION_ENTRY_SIZE)
    if (rg_load_u16(entry) == type && index-- == 0)
      return bytes + rg_load_u32(entry + 4);
  return 0;
}
