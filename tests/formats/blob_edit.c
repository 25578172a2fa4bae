#include "blob_edit.h"

#include <stdlib.h>
#include <string.h>

#include "bytes.h"
#include "crc32.h"

static uint8_t* entry_of(uint8_t* blob, uint32_t k) {
  return blob + RG_HEADER_SIZE + k * RG_SECTION_ENTRY_SIZE;
}

uint32_t assemble_blob(const blob_section* sections, uint32_t num_sections,
                       uint8_t* blob) {
  uint32_t end = RG_HEADER_SIZE + num_sections * RG_SECTION_ENTRY_SIZE;
  memset(blob, 0, RG_HEADER_SIZE);
  for (uint32_t k = 0; k < num_sections; ++k) {
    uint8_t* entry = entry_of(blob, k);
    rg_store_u16(entry, sections[k].type);
    rg_store_u16(entry + 2, sections[k].flags);
    rg_store_u32(entry + 4, end);
    rg_store_u32(entry + 8, sections[k].size);
    memcpy(blob + end, sections[k].bytes, sections[k].size);
    end += sections[k].size;
  }
  memcpy(blob, "RAYGRID", 8);
  rg_store_u16(blob + 8, RG_FORMAT_MAJOR);
  rg_store_u32(blob + 12, end);
  rg_store_u16(blob + 16, (uint16_t)num_sections);
  rg_store_u16(blob + 18, RG_HEADER_SIZE);
  repair_crcs(blob, end);
  return end;
}

blob_section section_of(const uint8_t* blob, uint32_t k) {
  const uint8_t* entry = blob + RG_HEADER_SIZE + k * RG_SECTION_ENTRY_SIZE;
  const blob_section section = {rg_load_u16(entry), rg_load_u16(entry + 2),
                                blob + rg_load_u32(entry + 4),
                                rg_load_u32(entry + 8)};
  return section;
}

static void repair_section_crc(uint8_t* blob, uint32_t size, uint8_t* entry) {
  const uint32_t offset = rg_load_u32(entry + 4);
  const uint32_t section_size = rg_load_u32(entry + 8);
  if (offset <= size && section_size <= size - offset)
    rg_store_u32(entry + 12, rg_crc32(0, blob + offset, section_size));
}

void repair_crcs(uint8_t* blob, uint32_t size) {
  const uint32_t num_sections = rg_load_u16(blob + 16);
  const uint32_t table_size = num_sections * RG_SECTION_ENTRY_SIZE;
  if (RG_HEADER_SIZE + table_size > size) return;
  for (uint32_t k = 0; k < num_sections; ++k)
    repair_section_crc(blob, size, entry_of(blob, k));
  const uint32_t crc = rg_crc32(0, blob, RG_HEADER_SIZE - 4);
  rg_store_u32(blob + 28, rg_crc32(crc, blob + RG_HEADER_SIZE, table_size));
}

rg_status open_copy(const uint8_t* bytes, uint32_t size) {
  uint8_t* copy = malloc(size != 0 ? size : 1);
  if (!copy) return RG_ERR_ARGUMENT;
  memcpy(copy, bytes, size);
  rg_blob blob;
  const rg_status status = rg_blob_open(copy, size, &blob);
  free(copy);
  return status;
}
