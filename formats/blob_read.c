/* Checks the header, the section table and the CRCs. */
#include "blob_checks.h"
#include "bytes.h"
#include "crc32.h"
#include "rg_blob.h"

/* The size of the fixed fields of each section type; 0: unknown type. This is a
 * table, since compilers for Armv6-M would call a library function for a
 * switch. */
static const uint8_t kFieldsSizes[RG_NUM_SECTION_TYPES] = {RG_SECTION_SIZES};

/* Sections must follow the section table without gaps, in the order of the
 * table. */
static rg_status check_sections(const uint8_t* bytes, const uint8_t* table_end,
                                rg_sections* sections) {
  const uint8_t* const end = bytes + rg_load_u32(bytes + RG_HEADER_TOTAL_SIZE);
  const uint8_t* entry = bytes + RG_HEADER_SIZE;
  const uint8_t* section = table_end;
  do {
    const uint32_t size = rg_load_u32(entry + RG_ENTRY_SIZE);
    if (rg_load_u32(entry + RG_ENTRY_OFFSET) != (uint32_t)(section - bytes) ||
        size % 4 != 0 || size - 1 >= (uint32_t)(end - section))
      return RG_ERR_SECTION_TABLE;
    if (rg_crc32(0, section, size) != rg_load_u32(entry + RG_ENTRY_CRC))
      return RG_ERR_SECTION_CRC;
    const uint32_t type = rg_load_u16(entry + RG_ENTRY_TYPE);
    if (type >= RG_NUM_SECTION_TYPES || kFieldsSizes[type] == 0) {
      if ((rg_load_u16(entry + RG_ENTRY_FLAGS) & RG_SECTION_CRITICAL) != 0)
        return RG_ERR_SECTION_UNKNOWN;
    } else {
      sections->of[type].bytes = section;
      sections->of[type].size = size;
      if (size < kFieldsSizes[type]) return RG_ERR_SECTION_SIZE;
    }
    section += size;
    entry += RG_SECTION_ENTRY_SIZE;
  } while (entry != table_end);
  return section != end ? RG_ERR_SECTION_TABLE : RG_OK;
}

rg_status rg_check_table(const uint8_t* bytes, uint32_t num_bytes,
                         rg_sections* sections) {
  if ((uintptr_t)bytes % 4 != 0) return RG_ERR_MISALIGNED;
  for (uint32_t type = 0; type < RG_NUM_SECTION_TYPES; ++type) {
    sections->of[type].bytes = 0;
    sections->of[type].size = 0;
  }
  if (num_bytes < RG_HEADER_SIZE) return RG_ERR_TRUNCATED;
  /* "RAYG", "RID\0" */
  if (rg_load_u32(bytes + RG_HEADER_MAGIC) != 0x47594152u ||
      rg_load_u32(bytes + RG_HEADER_MAGIC + 4) != 0x444952u)
    return RG_ERR_MAGIC;
  if (rg_load_u16(bytes + RG_HEADER_MAJOR) != RG_FORMAT_MAJOR)
    return RG_ERR_VERSION;

  const uint32_t total_size = rg_load_u32(bytes + RG_HEADER_TOTAL_SIZE);
  const uint32_t num_sections = rg_load_u16(bytes + RG_HEADER_SECTION_COUNT);
  const uint32_t table_size = num_sections * RG_SECTION_ENTRY_SIZE;
  if (total_size > num_bytes) return RG_ERR_TRUNCATED;
  if (total_size % 4 != 0 ||
      rg_load_u16(bytes + RG_HEADER_HEADER_SIZE) != RG_HEADER_SIZE ||
      num_sections - 1 >= RG_MAX_SECTIONS ||
      RG_HEADER_SIZE + table_size > total_size)
    return RG_ERR_HEADER;

  const uint8_t* const table = bytes + RG_HEADER_SIZE;
  const uint32_t crc =
      rg_crc32(rg_crc32(0, bytes, RG_HEADER_HEADER_CRC), table, table_size);
  if (crc != rg_load_u32(bytes + RG_HEADER_HEADER_CRC))
    return RG_ERR_HEADER_CRC;
  return check_sections(bytes, table + table_size, sections);
}
