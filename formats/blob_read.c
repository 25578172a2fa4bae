#include <stddef.h>

#include "bytes.h"
#include "crc32.h"
#include "rg_blob.h"

static const uint8_t kMagic[8] = {'R', 'A', 'Y', 'G', 'R', 'I', 'D', 0};

/* Magic, version, sizes, and the CRC over header and section table. */
static rg_status check_header(const uint8_t* bytes, uint32_t num_bytes) {
  if (num_bytes < RG_HEADER_SIZE) return RG_ERR_TRUNCATED;
  for (uint32_t i = 0; i < sizeof(kMagic); ++i)
    if (bytes[i] != kMagic[i]) return RG_ERR_MAGIC;
  if (rg_load_u16(bytes + 8) != RG_FORMAT_MAJOR) return RG_ERR_VERSION;

  const uint32_t total_size = rg_load_u32(bytes + 12);
  const uint32_t num_sections = rg_load_u16(bytes + 16);
  if (total_size > num_bytes) return RG_ERR_TRUNCATED;
  if (total_size % 4 != 0 || rg_load_u16(bytes + 18) != RG_HEADER_SIZE ||
      num_sections == 0 || num_sections > RG_MAX_SECTIONS)
    return RG_ERR_HEADER;
  const uint32_t table_size = num_sections * RG_SECTION_ENTRY_SIZE;
  if (RG_HEADER_SIZE + table_size > total_size) return RG_ERR_HEADER;

  const uint32_t crc = rg_crc32(rg_crc32(0, bytes, RG_HEADER_SIZE - 4),
                                bytes + RG_HEADER_SIZE, table_size);
  if (crc != rg_load_u32(bytes + 28)) return RG_ERR_HEADER_CRC;
  if ((rg_load_u32(bytes + 20) | rg_load_u32(bytes + 24)) != 0)
    return RG_ERR_RESERVED;
  return RG_OK;
}

/* The sections tile the blob, in the order of the table, and are undamaged. */
static rg_status check_section_table(const uint8_t* bytes) {
  const uint32_t total_size = rg_load_u32(bytes + 12);
  const uint32_t num_sections = rg_load_u16(bytes + 16);
  uint32_t end = RG_HEADER_SIZE + num_sections * RG_SECTION_ENTRY_SIZE;
  for (uint32_t i = 0; i < num_sections; ++i) {
    const uint8_t* entry = bytes + RG_HEADER_SIZE + i * RG_SECTION_ENTRY_SIZE;
    const uint32_t offset = rg_load_u32(entry + 4);
    const uint32_t size = rg_load_u32(entry + 8);
    if (offset != end || size == 0 || size % 4 != 0 ||
        size > total_size - offset)
      return RG_ERR_SECTION_TABLE;
    end = offset + size;
  }
  if (end != total_size) return RG_ERR_SECTION_TABLE;

  for (uint32_t i = 0; i < num_sections; ++i) {
    const uint8_t* entry = bytes + RG_HEADER_SIZE + i * RG_SECTION_ENTRY_SIZE;
    const uint8_t* section = bytes + rg_load_u32(entry + 4);
    if (rg_crc32(0, section, rg_load_u32(entry + 8)) != rg_load_u32(entry + 12))
      return RG_ERR_SECTION_CRC;
  }
  return RG_OK;
}

/* Where the offset of a section of each type is noted. A table, since Armv6-M
 * compilers would call their library for a switch. */
static const uint8_t kNotes[] = {0,
                                 offsetof(rg_blob, camera),
                                 offsetof(rg_blob, grid),
                                 offsetof(rg_blob, remap),
                                 offsetof(rg_blob, quality),
                                 offsetof(rg_blob, line_points),
                                 offsetof(rg_blob, mask),
                                 offsetof(rg_blob, uncertainty),
                                 0,
                                 offsetof(rg_blob, start)};

/* NULL for an unknown type. */
static uint32_t* find_note(uint32_t type, rg_blob* blob) {
  if (type >= sizeof(kNotes) || kNotes[type] == 0) return 0;
  return (uint32_t*)(void*)((uint8_t*)blob + kNotes[type]);
}

/* Notes where the section lies; of remap tables, the first. */
static rg_status find_section(const uint8_t* entry, rg_blob* blob) {
  const uint32_t type = rg_load_u16(entry);
  const uint32_t flags = rg_load_u16(entry + 2);
  if (flags > RG_SECTION_CRITICAL) return RG_ERR_SECTION_FLAGS;
  uint32_t* const note = find_note(type, blob);
  if (!note) return flags != 0 ? RG_ERR_SECTION_UNKNOWN : RG_OK;

  const uint32_t must_be_critical = type == RG_SECTION_CAMERA ||
                                    type == RG_SECTION_CENTRAL_GRID ||
                                    type == RG_SECTION_LINE_POINTS;
  if (flags != must_be_critical) return RG_ERR_SECTION_FLAGS;
  if (*note == 0)
    *note = rg_load_u32(entry + 4);
  else if (type != RG_SECTION_REMAP)
    return RG_ERR_SECTION_DUPLICATE;
  return RG_OK;
}

static rg_status check_new_section(uint32_t type, const uint8_t* section,
                                   uint32_t size, const rg_blob* blob) {
  const uint8_t* grid = blob->bytes + blob->grid;
  if (type == RG_SECTION_LINE_POINTS)
    return rg_check_line_points(section, size, grid);
  if (type == RG_SECTION_MASK)
    return rg_check_mask(section, size, blob->bytes + blob->camera);
  if (type == RG_SECTION_UNCERTAINTY)
    return rg_check_uncertainty(section, size, grid);
  return RG_OK;
}

/* All but the camera and the grid, which are checked first. */
static rg_status check_section(const uint8_t* entry, const rg_blob* blob) {
  const uint8_t* section = blob->bytes + rg_load_u32(entry + 4);
  const uint32_t size = rg_load_u32(entry + 8);
  const uint32_t type = rg_load_u16(entry);
  if (type == RG_SECTION_REMAP)
    return rg_check_remap(section, size, blob->bytes + blob->camera);
  if (type == RG_SECTION_QUALITY) return rg_check_quality(section, size);
  if (type == RG_SECTION_START) return rg_check_start(section, size);
  return check_new_section(type, section, size, blob);
}

static rg_status find_and_check_sections(rg_blob* blob) {
  const uint8_t* table = blob->bytes + RG_HEADER_SIZE;
  const uint8_t* table_end =
      table + rg_load_u16(blob->bytes + 16) * RG_SECTION_ENTRY_SIZE;
  uint32_t camera_size = 0, grid_size = 0;
  for (const uint8_t* entry = table; entry < table_end;
       entry += RG_SECTION_ENTRY_SIZE) {
    const rg_status status = find_section(entry, blob);
    if (status != RG_OK) return status;
    const uint32_t type = rg_load_u16(entry), size = rg_load_u32(entry + 8);
    if (type == RG_SECTION_CAMERA) camera_size = size;
    if (type == RG_SECTION_CENTRAL_GRID) grid_size = size;
  }
  if (blob->camera == 0 || blob->grid == 0) return RG_ERR_SECTION_MISSING;

  const uint8_t* const camera = blob->bytes + blob->camera;
  rg_status status = rg_check_camera(camera, camera_size);
  if (status == RG_OK)
    status = rg_check_grid(blob->bytes + blob->grid, grid_size, camera);
  for (const uint8_t* entry = table; status == RG_OK && entry < table_end;
       entry += RG_SECTION_ENTRY_SIZE)
    status = check_section(entry, blob);
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

rg_status rg_blob_open(const void* bytes, uint32_t num_bytes, rg_blob* blob) {
  if (!bytes || !blob) return RG_ERR_ARGUMENT;
  if ((uintptr_t)bytes % 4 != 0) return RG_ERR_MISALIGNED;

  const uint8_t* const p = (const uint8_t*)bytes;
  rg_status status = check_header(p, num_bytes);
  if (status == RG_OK) status = check_section_table(p);
  if (status != RG_OK) return status;

  rg_blob found = {p, rg_load_u32(p + 12), 0, 0, 0, 0, 0, 0, 0, 0};
  status = find_and_check_sections(&found);
  if (status != RG_OK) return status;
  /* Field by field: copied whole, some compilers would call memcpy. */
  blob->bytes = found.bytes;
  blob->size = found.size;
  blob->camera = found.camera;
  blob->grid = found.grid;
  blob->remap = found.remap;
  blob->quality = found.quality;
  blob->start = found.start;
  blob->line_points = found.line_points;
  blob->mask = found.mask;
  blob->uncertainty = found.uncertainty;
  return RG_OK;
}
