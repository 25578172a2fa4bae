/* The header, the section table, and what is the same in all sections. */
#include "blob_checks.h"
#include "bytes.h"
#include "crc32.h"
#include "rg_blob.h"

/* Compilers would call memset. */
#if defined(__GNUC__)
#define RG_KEEP_LOOP() __asm__ volatile("")
#else
#define RG_KEEP_LOOP()
#endif

/* Magic, version, sizes, and the CRC over header and section table. */
static rg_fault check_header(const uint8_t* bytes, uint32_t num_bytes) {
  if (num_bytes < RG_HEADER_SIZE) return -RG_ERR_TRUNCATED;
  if (rg_load_u32(bytes) != 0x47594152u || rg_load_u32(bytes + 4) != 0x444952u)
    return -RG_ERR_MAGIC; /* "RAYG", "RID\0" */
  if (rg_load_u16(bytes + 8) != RG_FORMAT_MAJOR) return -RG_ERR_VERSION;

  const uint32_t total_size = rg_load_u32(bytes + 12);
  const uint32_t num_sections = rg_load_u16(bytes + 16);
  const uint32_t table_size = num_sections * RG_SECTION_ENTRY_SIZE;
  if (total_size > num_bytes) return -RG_ERR_TRUNCATED;
  if (total_size % 4 != 0 || rg_load_u16(bytes + 18) != RG_HEADER_SIZE ||
      num_sections - 1 >= RG_MAX_SECTIONS ||
      RG_HEADER_SIZE + table_size > total_size)
    return -RG_ERR_HEADER;

  const uint32_t crc = rg_crc32(rg_crc32(0, bytes, RG_HEADER_SIZE - 4),
                                bytes + RG_HEADER_SIZE, table_size);
  if (crc != rg_load_u32(bytes + 28)) return -RG_ERR_HEADER_CRC;
  if ((rg_load_u32(bytes + 20) | rg_load_u32(bytes + 24)) != 0)
    return -RG_ERR_RESERVED;
  return 0;
}

/* Bytes of the fields of each type of section; 0: unknown. A table, since
 * Armv6-M compilers would call their library for a switch. */
static const uint8_t kFieldsSizes[RG_NUM_SECTION_TYPES] = {
    0,
    RG_CAMERA_SIZE,
    RG_GRID_FIELDS_SIZE,
    RG_REMAP_FIELDS_SIZE,
    RG_QUALITY_SIZE,
    RG_LINE_POINTS_FIELDS_SIZE,
    RG_MASK_FIELDS_SIZE,
    RG_UNCERTAINTY_FIELDS_SIZE,
    0,
    0, /* a start for projection, until version 1.2 */
    RG_GRID_FIELDS_SIZE};

#define CRITICAL_TYPES                                       \
  (1u << RG_SECTION_CAMERA | 1u << RG_SECTION_CENTRAL_GRID | \
   1u << RG_SECTION_LINE_POINTS)

/* What an entry of the table says of its section, but for its place. Notes
 * where the section lies; of remap tables, the first. */
static rg_fault check_entry(const uint8_t* entry, const uint8_t* section,
                            const uint8_t** sections) {
  const uint32_t size = rg_load_u32(entry + 8);
  const uint32_t type = rg_load_u16(entry), flags = rg_load_u16(entry + 2);
  if (rg_crc32(0, section, size) != rg_load_u32(entry + 12))
    return -RG_ERR_SECTION_CRC;
  if (flags > RG_SECTION_CRITICAL) return -RG_ERR_SECTION_FLAGS;
  const uint32_t fields_size =
      type < RG_NUM_SECTION_TYPES ? kFieldsSizes[type] : 0;
  if (fields_size == 0) return flags != 0 ? -RG_ERR_SECTION_UNKNOWN : 0;
  if (flags != (CRITICAL_TYPES >> type & 1u)) return -RG_ERR_SECTION_FLAGS;
  if (!sections[type])
    sections[type] = section;
  else if (type != RG_SECTION_REMAP)
    return -RG_ERR_SECTION_DUPLICATE;
  return size < fields_size ? -RG_ERR_SECTION_SIZE : 0;
}

/* The sections tile the blob, in the order of the table; then what is in them,
 * by what is in others. */
static rg_fault check_sections(const uint8_t* bytes, const uint8_t** sections) {
  const uint8_t* const table = bytes + RG_HEADER_SIZE;
  const uint8_t* const table_end =
      table + rg_load_u16(bytes + 16) * RG_SECTION_ENTRY_SIZE;
  const uint8_t* section = table_end;
  uint32_t rest = rg_load_u32(bytes + 12) - (uint32_t)(table_end - bytes);
  rg_fault fault = 0;
  for (const uint8_t* entry = table; entry != table_end;
       entry += RG_SECTION_ENTRY_SIZE) {
    const uint32_t size = rg_load_u32(entry + 8);
    if (rg_load_u32(entry + 4) != (uint32_t)(section - bytes) || size == 0 ||
        size % 4 != 0 || size > rest)
      return -RG_ERR_SECTION_TABLE;
    fault = check_entry(entry, section, sections);
    if (fault) return fault;
    section += size;
    rest -= size;
  }
  if (rest != 0) return -RG_ERR_SECTION_TABLE;
  if (!sections[RG_SECTION_CAMERA] || !sections[RG_SECTION_CENTRAL_GRID])
    return -RG_ERR_SECTION_MISSING;
  for (const uint8_t* entry = table; entry != table_end && !fault;
       entry += RG_SECTION_ENTRY_SIZE)
    fault = rg_check_section(rg_load_u16(entry), bytes + rg_load_u32(entry + 4),
                             rg_load_u32(entry + 8), sections);
  return fault;
}

rg_status rg_blob_check(const void* bytes, uint32_t num_bytes,
                        const uint8_t* sections[RG_NUM_SECTION_TYPES]) {
  if (!bytes) return RG_ERR_ARGUMENT;
  if ((uintptr_t)bytes % 4 != 0) return RG_ERR_MISALIGNED;
  for (int type = 0; type < RG_NUM_SECTION_TYPES; ++type) {
    sections[type] = 0;
    RG_KEEP_LOOP();
  }
  rg_fault fault = check_header(bytes, num_bytes);
  if (!fault) fault = check_sections(bytes, sections);
  return (rg_status)-fault;
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
