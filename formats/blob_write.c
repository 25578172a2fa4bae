#include <string.h>

#include "bytes.h"
#include "crc32.h"
#include "rg_blob.h"

#define rg_store_u8(p, value) (*(p) = (value))
#define STORE_MEMBER(s, kind, offset, member) \
  rg_store_##kind(section + (offset), (s)->member);

static uint32_t grid_size(const rg_blob_contents* contents) {
  const uint32_t count =
      (uint32_t)contents->grid->columns * contents->grid->rows;
  return RG_GRID_FIELDS_SIZE +
         (contents->narrow ? RG_NARROW_PLANE_SIZE + RG_NARROW_POINT_SIZE * count
                           : RG_CONTROL_POINT_SIZE * count);
}

static uint32_t bits_size(uint32_t num_bits) {
  return (num_bits + 31) / 32 * 4;
}

static uint32_t num_blocks(const rg_remap_section* remap) {
  return (uint32_t)(remap->columns - 1) * (uint32_t)(remap->rows - 1);
}

static uint32_t vertex_size(const rg_remap_section* remap) {
  return remap->part_log2 != 0 ? RG_BENT_VERTEX_SIZE : RG_VERTEX_SIZE;
}

static uint32_t remap_fields_size(const rg_remap_section* remap) {
  return remap->has_view ? RG_VIEW_FIELDS_SIZE : RG_REMAP_FIELDS_SIZE;
}

uint32_t rg_remap_section_size(const rg_remap_section* remap) {
  return remap_fields_size(remap) +
         vertex_size(remap) * remap->columns * remap->rows +
         bits_size(num_blocks(remap));
}

static uint32_t inverse_size(const rg_inverse_section* inverse) {
  return RG_GRID_FIELDS_SIZE + RG_NARROW_PLANE_SIZE +
         RG_NARROW_POINT_SIZE * (uint32_t)inverse->columns * inverse->rows;
}

static uint32_t line_points_size(const rg_grid_section* grid) {
  return RG_LINE_POINTS_FIELDS_SIZE +
         RG_LINE_POINT_SIZE * (uint32_t)grid->columns * grid->rows;
}

static uint32_t valid_mask_size(const rg_mask_section* mask) {
  return RG_MASK_FIELDS_SIZE + bits_size((uint32_t)mask->columns * mask->rows);
}

static uint32_t uncertainty_size(const rg_uncertainty_section* uncertainty) {
  const uint32_t count = (uint32_t)uncertainty->columns * uncertainty->rows;
  return RG_UNCERTAINTY_FIELDS_SIZE + (count + 1) / 2 * 4;
}

static uint32_t num_sections(const rg_blob_contents* contents) {
  return 2u + (contents->remap != 0) + contents->num_more_remaps +
         (contents->quality != 0) + (contents->line_points_q28 != 0) +
         (contents->mask != 0) + (contents->uncertainty != 0) +
         (contents->inverse != 0) + (contents->num_modes != 0) +
         (contents->capture != 0) + (contents->stack != 0) +
         (contents->row_time != 0);
}

/* The number of remap tables of the blob. */
static uint32_t num_remaps(const rg_blob_contents* contents) {
  return contents->remap ? 1 + contents->num_more_remaps : 0;
}

static uint32_t get_knot_size(const rg_blob_contents* contents) {
  uint32_t sample_size = grid_size(contents) + RG_STACK_SAMPLE_VALUE_SIZE;
  if (contents->inverse) sample_size += inverse_size(contents->inverse);
  if (contents->remap) sample_size += rg_remap_section_size(contents->remap);
  for (uint32_t k = 0; k < contents->num_more_remaps; ++k)
    sample_size += rg_remap_section_size(contents->more_remaps[k].section);
  return sample_size;
}

static uint32_t stack_size(const rg_blob_contents* contents) {
  return RG_STACK_FIELDS_SIZE +
         get_knot_size(contents) * contents->stack->num_samples;
}

uint32_t rg_blob_size(const rg_blob_contents* contents) {
  uint32_t size =
      RG_HEADER_SIZE + RG_SECTION_ENTRY_SIZE * num_sections(contents);
  size += RG_CAMERA_SIZE + grid_size(contents);
  if (contents->remap) size += rg_remap_section_size(contents->remap);
  for (uint32_t k = 0; k < contents->num_more_remaps; ++k)
    size += rg_remap_section_size(contents->more_remaps[k].section);
  if (contents->quality) size += RG_QUALITY_SIZE;
  if (contents->line_points_q28) size += line_points_size(contents->grid);
  if (contents->mask) size += valid_mask_size(contents->mask);
  if (contents->uncertainty) size += uncertainty_size(contents->uncertainty);
  if (contents->inverse) size += inverse_size(contents->inverse);
  if (contents->capture) size += RG_CAPTURE_SIZE;
  if (contents->stack) size += stack_size(contents);
  if (contents->row_time) size += RG_ROW_TIME_SIZE;
  return size + RG_MODE_SIZE * contents->num_modes;
}

uint32_t rg_grid_scale_q32(uint32_t cells, uint32_t span) {
  return (uint32_t)(((uint64_t)cells << 48) / span);
}

static void write_camera(const rg_camera_section* camera, uint8_t* section) {
  RG_CAMERA_MEMBERS(STORE_MEMBER, camera)
  rg_store_u32(section + RG_CAMERA_RESERVED, 0);
  memcpy(section + RG_CAMERA_NAME, camera->name, RG_TEXT_SIZE);
  memcpy(section + RG_CAMERA_SERIAL, camera->serial, RG_TEXT_SIZE);
}

/* Writes a plane and `count` residuals. */
static void write_narrow(const rg_narrow_grid* narrow, uint32_t count,
                         uint8_t* data) {
  for (uint32_t c = 0; c < 2; ++c) {
    rg_store_i32(data + RG_PLANE_ORIGIN + 4 * c, narrow->origin_q29[c]);
    rg_store_i32(data + RG_PLANE_COLUMN_STEP + 4 * c,
                 narrow->column_step_q29[c]);
    rg_store_i32(data + RG_PLANE_ROW_STEP + 4 * c, narrow->row_step_q29[c]);
  }
  for (uint32_t i = 0; i < count; ++i)
    rg_store_u16(data + RG_NARROW_PLANE_SIZE + 2 * i,
                 (uint16_t)narrow->residuals[i]);
}

/* Writes the fields after the scales, which both kinds of grids have in common.
 */
static void write_number_format(uint32_t fraction_bits, uint8_t* section) {
  rg_store_u16(section + RG_GRID_CHART, RG_CHART_STEREOGRAPHIC);
  rg_store_u16(section + RG_GRID_FRACTION_BITS, (uint16_t)fraction_bits);
  rg_store_u32(section + RG_GRID_DATA_OFFSET, RG_GRID_FIELDS_SIZE);
}

/* narrow: 16-bit control points instead of points_q29, or NULL. */
static void write_grid(const rg_grid_section* grid, const int32_t* points_q29,
                       const rg_narrow_grid* narrow, uint8_t* section) {
  RG_GRID_MEMBERS(STORE_MEMBER, grid)
  write_number_format(narrow ? narrow->fraction_bits : RG_CONTROL_POINT_BITS,
                      section);
  rg_store_u32(section + RG_GRID_RESERVED, 0);
  uint8_t* const data = section + RG_GRID_FIELDS_SIZE;
  const uint32_t count = 2 * (uint32_t)grid->columns * grid->rows;
  if (narrow) {
    write_narrow(narrow, count, data);
    return;
  }
  for (uint32_t i = 0; i < count; ++i)
    rg_store_i32(data + 4 * i, points_q29[i]);
}

/* The padding is zero. */
static void write_bits(const uint8_t* bits, uint32_t num_bits, uint8_t* bytes) {
  memset(bytes, 0, bits_size(num_bits));
  for (uint32_t k = 0; k < num_bits; ++k)
    bytes[k / 8] = (uint8_t)(bytes[k / 8] | (bits[k / 8] & 1u << k % 8));
}

static void write_view(const rg_remap_section* remap, uint8_t* section) {
  section[RG_REMAP_BEND_SHIFT] = (uint8_t)(remap->bend_shift | RG_HAS_VIEW);
  RG_VIEW_MEMBERS(STORE_MEMBER, remap)
  section[RG_VIEW_RESERVED] = 0;
  for (uint32_t k = 0; k < 9; ++k)
    rg_store_i32(section + RG_VIEW_ROTATION + 4 * k, remap->rotation_q30[k]);
}

void rg_write_remap(const rg_remap_section* remap, const int16_t* residuals,
                    uint8_t* section) {
  RG_REMAP_MEMBERS(STORE_MEMBER, remap)
  rg_store_u32(section + RG_REMAP_DATA_OFFSET, remap_fields_size(remap));
  if (remap->has_view) write_view(remap, section);
  uint8_t* data = section + remap_fields_size(remap);
  const uint32_t count = (uint32_t)remap->columns * remap->rows;
  for (uint32_t i = 0; i < count; ++i, data += vertex_size(remap)) {
    for (uint32_t c = 0; c < 2; ++c)
      rg_store_u16(data + RG_VERTEX_X + 2 * c, (uint16_t)residuals[2 * i + c]);
    if (remap->part_log2 != 0)
      memcpy(data + RG_VERTEX_HX, remap->bends + 4 * i, 4);
  }
  write_bits(remap->empty_blocks, num_blocks(remap), data);
}

static void write_quality(const rg_quality_section* quality, uint8_t* section) {
  RG_QUALITY_MEMBERS(STORE_MEMBER, quality)
}

static void write_inverse(const rg_inverse_section* inverse,
                          const rg_narrow_grid* points, uint8_t* section) {
  RG_INVERSE_MEMBERS(STORE_MEMBER, inverse)
  write_number_format(points->fraction_bits, section);
  write_narrow(points, 2 * (uint32_t)inverse->columns * inverse->rows,
               section + RG_GRID_FIELDS_SIZE);
}

static void write_line_points(const rg_grid_section* grid,
                              const int32_t* points, uint8_t* section) {
  rg_store_u16(section + RG_LINE_POINTS_FRACTION_BITS, RG_LINE_POINT_BITS);
  rg_store_u16(section + RG_LINE_POINTS_RESERVED, 0);
  rg_store_u32(section + RG_LINE_POINTS_DATA_OFFSET,
               RG_LINE_POINTS_FIELDS_SIZE);
  const uint32_t count = 3 * (uint32_t)grid->columns * grid->rows;
  for (uint32_t i = 0; i < count; ++i)
    rg_store_i32(section + RG_LINE_POINTS_FIELDS_SIZE + 4 * i, points[i]);
}

static void write_mask(const rg_mask_section* mask, uint8_t* section) {
  RG_MASK_MEMBERS(STORE_MEMBER, mask)
  section[RG_MASK_RESERVED] = 0;
  rg_store_u16(section + RG_MASK_RESERVED + 1, 0);
  rg_store_u32(section + RG_MASK_DATA_OFFSET, RG_MASK_FIELDS_SIZE);
  write_bits(mask->bits, (uint32_t)mask->columns * mask->rows,
             section + RG_MASK_FIELDS_SIZE);
}

static void write_uncertainty(const rg_uncertainty_section* uncertainty,
                              const uint16_t* values_q12, uint8_t* section) {
  RG_UNCERTAINTY_MEMBERS(STORE_MEMBER, uncertainty)
  rg_store_u32(section + RG_UNCERTAINTY_DATA_OFFSET,
               RG_UNCERTAINTY_FIELDS_SIZE);
  const uint32_t count = (uint32_t)uncertainty->columns * uncertainty->rows;
  uint8_t* const data = section + RG_UNCERTAINTY_FIELDS_SIZE;
  for (uint32_t i = 0; i < count; ++i)
    rg_store_u16(data + 2 * i, values_q12[i]);
  if (count % 2 != 0) rg_store_u16(data + 2 * count, 0);
}

static void write_mode(const rg_mode_section* mode, uint8_t* section) {
  RG_MODE_MEMBERS(STORE_MEMBER, mode)
  memset(section + RG_MODE_RESERVED, 0, RG_MODE_NAME - RG_MODE_RESERVED);
  memcpy(section + RG_MODE_NAME, mode->name, RG_TEXT_SIZE);
}

static void write_capture(const rg_capture_section* capture, uint8_t* section) {
  RG_CAPTURE_MEMBERS(STORE_MEMBER, capture)
  rg_store_u16(section + RG_CAPTURE_RESERVED, 0);
}

/* Writes a sample: its grids and tables in the order of write_parts(), then its
 * value. Returns the address of the next sample. */
static uint8_t* write_stack_sample(const rg_blob_contents* contents,
                                   const rg_stack_sample_contents* sample,
                                   uint8_t* part) {
  write_grid(contents->grid, sample->control_points_q29, sample->narrow, part);
  part += grid_size(contents);
  for (uint32_t k = 0; k < num_remaps(contents); ++k) {
    const rg_remap_contents* const remap = &sample->remaps[k];
    rg_write_remap(remap->section, remap->residuals, part);
    part += rg_remap_section_size(remap->section);
  }
  if (contents->inverse) {
    write_inverse(contents->inverse, sample->inverse_points, part);
    part += inverse_size(contents->inverse);
  }
  rg_store_i32(part, sample->value_q16);
  return part + RG_STACK_SAMPLE_VALUE_SIZE;
}

static void write_stack(const rg_blob_contents* contents, uint8_t* section) {
  const rg_stack_contents* const stack = contents->stack;
  rg_store_u16(section + RG_STACK_CONDITION, stack->condition);
  rg_store_u16(section + RG_STACK_KNOTS, stack->num_samples);
  uint8_t* sample = section + RG_STACK_FIELDS_SIZE;
  for (uint32_t k = 0; k < stack->num_samples; ++k)
    sample = write_stack_sample(contents, &stack->samples[k], sample);
}

static void write_row_time(const rg_row_time_section* row_time,
                           uint8_t* section) {
  RG_ROW_TIME_MEMBERS(STORE_MEMBER, row_time)
}

typedef struct section_writer {
  uint8_t* bytes;
  uint8_t* entry;
  uint32_t end;
  uint16_t minor; /* lowest version that supports the sections written so far */
} section_writer;

/* Reserves the next section and writes its entry, except for the CRC. */
static uint8_t* begin_section(section_writer* writer, uint16_t type,
                              uint32_t size) {
  static const uint8_t kMinors[] = {RG_SECTION_MINORS};
  if (kMinors[type] > writer->minor) writer->minor = kMinors[type];
  rg_store_u16(writer->entry + RG_ENTRY_TYPE, type);
  rg_store_u16(writer->entry + RG_ENTRY_FLAGS, RG_CRITICAL_TYPES >> type & 1u);
  rg_store_u32(writer->entry + RG_ENTRY_OFFSET, writer->end);
  rg_store_u32(writer->entry + RG_ENTRY_SIZE, size);
  uint8_t* section = writer->bytes + writer->end;
  writer->entry += RG_SECTION_ENTRY_SIZE;
  writer->end += size;
  return section;
}

static void begin_remap(const rg_remap_section* remap, const int16_t* residuals,
                        section_writer* writer) {
  rg_write_remap(
      remap, residuals,
      begin_section(writer, RG_SECTION_REMAP, rg_remap_section_size(remap)));
}

/* Writes the sections after the camera and the modes that have no counterpart
 * in samples of an operating-point model. */
static void write_lone_sections(const rg_blob_contents* contents,
                                section_writer* writer) {
  if (contents->quality)
    write_quality(contents->quality,
                  begin_section(writer, RG_SECTION_QUALITY, RG_QUALITY_SIZE));
  if (contents->line_points_q28)
    write_line_points(contents->grid, contents->line_points_q28,
                      begin_section(writer, RG_SECTION_LINE_POINTS,
                                    line_points_size(contents->grid)));
  if (contents->mask)
    write_mask(contents->mask, begin_section(writer, RG_SECTION_MASK,
                                             valid_mask_size(contents->mask)));
  if (contents->uncertainty)
    write_uncertainty(contents->uncertainty, contents->uncertainties_q12,
                      begin_section(writer, RG_SECTION_UNCERTAINTY,
                                    uncertainty_size(contents->uncertainty)));
  if (contents->capture)
    write_capture(contents->capture,
                  begin_section(writer, RG_SECTION_CAPTURE, RG_CAPTURE_SIZE));
  if (contents->row_time)
    write_row_time(
        contents->row_time,
        begin_section(writer, RG_SECTION_ROW_TIME, RG_ROW_TIME_SIZE));
}

static void write_modes(const rg_blob_contents* contents,
                        section_writer* writer) {
  uint8_t* const section = begin_section(writer, RG_SECTION_MODES,
                                         RG_MODE_SIZE * contents->num_modes);
  for (uint32_t k = 0; k < contents->num_modes; ++k)
    write_mode(&contents->modes[k], section + RG_MODE_SIZE * k);
}

/* Writes the sections that have a counterpart in each sample of an
 * operating-point model. */
static void write_parts(const rg_blob_contents* contents,
                        section_writer* writer) {
  write_grid(
      contents->grid, contents->control_points_q29, contents->narrow,
      begin_section(writer, RG_SECTION_CENTRAL_GRID, grid_size(contents)));
  if (contents->remap)
    begin_remap(contents->remap, contents->residuals, writer);
  for (uint32_t k = 0; k < contents->num_more_remaps; ++k)
    begin_remap(contents->more_remaps[k].section,
                contents->more_remaps[k].residuals, writer);
  if (contents->inverse)
    write_inverse(contents->inverse, contents->inverse_points,
                  begin_section(writer, RG_SECTION_INVERSE,
                                inverse_size(contents->inverse)));
}

/* The operating-point model is the last section, immediately after the sections
 * with counterparts in its samples. */
static void write_sections(const rg_blob_contents* contents,
                           section_writer* writer) {
  write_camera(contents->camera,
               begin_section(writer, RG_SECTION_CAMERA, RG_CAMERA_SIZE));
  if (contents->num_modes != 0) write_modes(contents, writer);
  if (!contents->stack) write_parts(contents, writer);
  write_lone_sections(contents, writer);
  if (contents->stack) {
    write_parts(contents, writer);
    write_stack(contents,
                begin_section(writer, RG_SECTION_STACK, stack_size(contents)));
  }
}

/* The lowest minor version that supports the features of a table. */
static uint16_t min_version_for_remap(const rg_remap_section* remap) {
  if (remap->has_view) return 5;
  return remap->part_log2 != 0 ? 4 : 0;
}

static uint16_t min_version_for_remaps(const rg_blob_contents* contents) {
  uint16_t highest =
      contents->remap ? min_version_for_remap(contents->remap) : 0;
  for (uint32_t k = 0; k < contents->num_more_remaps; ++k) {
    const uint16_t version =
        min_version_for_remap(contents->more_remaps[k].section);
    if (version > highest) highest = version;
  }
  return highest;
}

/* The lowest minor version that supports the features of grids and tables. */
static uint16_t min_version_for_parts(const rg_blob_contents* contents) {
  const uint16_t version = min_version_for_remaps(contents);
  return version == 0 && contents->narrow ? 2 : version;
}

static void write_header(uint8_t* bytes, uint16_t minor, uint32_t size,
                         uint32_t sections) {
  memcpy(bytes + RG_HEADER_MAGIC, "RAYGRID", 8);
  rg_store_u16(bytes + RG_HEADER_MAJOR, RG_FORMAT_MAJOR);
  rg_store_u16(bytes + RG_HEADER_MINOR, minor);
  rg_store_u32(bytes + RG_HEADER_TOTAL_SIZE, size);
  rg_store_u16(bytes + RG_HEADER_SECTION_COUNT, (uint16_t)sections);
  rg_store_u16(bytes + RG_HEADER_HEADER_SIZE, RG_HEADER_SIZE);
  rg_store_u32(bytes + RG_HEADER_RESERVED, 0);
  rg_store_u32(bytes + RG_HEADER_RESERVED + 4, 0);
}

/* Sections are written first, since the section table contains their CRCs, and
 * the header's CRC covers the table. */
static void write_crcs(uint8_t* bytes, uint32_t sections) {
  uint8_t* table = bytes + RG_HEADER_SIZE;
  for (uint32_t i = 0; i < sections; ++i) {
    uint8_t* entry = table + i * RG_SECTION_ENTRY_SIZE;
    const uint8_t* section = bytes + rg_load_u32(entry + RG_ENTRY_OFFSET);
    rg_store_u32(entry + RG_ENTRY_CRC,
                 rg_crc32(0, section, rg_load_u32(entry + RG_ENTRY_SIZE)));
  }
  const uint32_t crc = rg_crc32(0, bytes, RG_HEADER_HEADER_CRC);
  rg_store_u32(bytes + RG_HEADER_HEADER_CRC,
               rg_crc32(crc, table, sections * RG_SECTION_ENTRY_SIZE));
}

static int has_blocks(const rg_remap_section* remap) {
  return remap->columns >= 2 && remap->rows >= 2 &&
         remap->columns <= RG_MAX_REMAP_SIZE / 8 + 1 &&
         remap->rows <= RG_MAX_REMAP_SIZE / 8 + 1;
}

/* Counts beyond these limits would make the computed sizes overflow. */
static rg_status check_counts(const rg_blob_contents* contents) {
  if (contents->grid->columns > RG_MAX_GRID_SIZE ||
      contents->grid->rows > RG_MAX_GRID_SIZE)
    return RG_ERR_GRID_SIZE;
  if (num_sections(contents) > RG_MAX_SECTIONS) return RG_ERR_HEADER;
  if (contents->num_modes > RG_MAX_MODES) return RG_ERR_MODE;
  if (contents->remap && !has_blocks(contents->remap))
    return RG_ERR_REMAP_BLOCK;
  for (uint32_t k = 0; k < contents->num_more_remaps; ++k)
    if (!has_blocks(contents->more_remaps[k].section))
      return RG_ERR_REMAP_BLOCK;
  if (contents->inverse && (contents->inverse->columns > RG_MAX_GRID_SIZE ||
                            contents->inverse->rows > RG_MAX_GRID_SIZE))
    return RG_ERR_GRID_SIZE;
  if (contents->mask && (contents->mask->columns > RG_MAX_IMAGE_SIZE / 4 ||
                         contents->mask->rows > RG_MAX_IMAGE_SIZE / 4))
    return RG_ERR_MASK;
  if (contents->uncertainty &&
      (contents->uncertainty->columns > RG_MAX_UNCERTAINTY_SIZE ||
       contents->uncertainty->rows > RG_MAX_UNCERTAINTY_SIZE))
    return RG_ERR_UNCERTAINTY;
  return RG_OK;
}

static int has_arrays(const rg_remap_section* remap, const int16_t* residuals) {
  return remap && residuals && remap->empty_blocks &&
         (remap->part_log2 == 0 || remap->bends);
}

/* Whether the arrays of a sample's grids and tables have the sizes of the
 * blob's own. */
static int is_like_own(const rg_blob_contents* contents,
                       const rg_stack_sample_contents* sample) {
  if (!sample->narrow != !contents->narrow ||
      (sample->narrow ? !sample->narrow->residuals
                      : !sample->control_points_q29))
    return 0;
  if (contents->inverse &&
      (!sample->inverse_points || !sample->inverse_points->residuals))
    return 0;
  if (contents->remap && !sample->remaps) return 0;
  for (uint32_t k = 0; k < num_remaps(contents); ++k) {
    const rg_remap_contents* const remap = &sample->remaps[k];
    const rg_remap_section* const own =
        k == 0 ? contents->remap : contents->more_remaps[k - 1].section;
    if (!has_arrays(remap->section, remap->residuals) ||
        remap->section->columns != own->columns ||
        remap->section->rows != own->rows ||
        remap_fields_size(remap->section) != remap_fields_size(own) ||
        vertex_size(remap->section) != vertex_size(own))
      return 0;
  }
  return 1;
}

static int is_whole_stack(const rg_blob_contents* contents) {
  const rg_stack_contents* const stack = contents->stack;
  if (!stack->samples || stack->num_samples > RG_MAX_STACK_SAMPLES) return 0;
  for (uint32_t k = 0; k < stack->num_samples; ++k)
    if (!is_like_own(contents, &stack->samples[k])) return 0;
  return 1;
}

/* Whether all arrays that the contents refer to are present. */
static int is_complete(const rg_blob_contents* contents) {
  if (!contents->camera || !contents->grid) return 0;
  if (contents->narrow ? !contents->narrow->residuals
                       : !contents->control_points_q29)
    return 0;
  if (contents->remap && !has_arrays(contents->remap, contents->residuals))
    return 0;
  if (contents->num_more_remaps != 0 &&
      (!contents->remap || !contents->more_remaps))
    return 0;
  for (uint32_t k = 0; k < contents->num_more_remaps; ++k)
    if (!has_arrays(contents->more_remaps[k].section,
                    contents->more_remaps[k].residuals))
      return 0;
  if (contents->inverse &&
      (!contents->inverse_points || !contents->inverse_points->residuals))
    return 0;
  if (contents->num_modes != 0 && !contents->modes) return 0;
  for (uint32_t k = 0; k < contents->num_modes; ++k)
    if (!contents->modes[k].name) return 0;
  if (contents->stack && !is_whole_stack(contents)) return 0;
  return (!contents->mask || contents->mask->bits) &&
         (!contents->uncertainty || contents->uncertainties_q12);
}

rg_status rg_blob_write(const rg_blob_contents* contents, void* buffer,
                        uint32_t buffer_size) {
  if (!contents || !buffer || !is_complete(contents)) return RG_ERR_ARGUMENT;
  if ((uintptr_t)buffer % 4 != 0) return RG_ERR_MISALIGNED;
  const rg_status status = check_counts(contents);
  if (status != RG_OK) return status;
  const uint32_t size = rg_blob_size(contents);
  if (size > buffer_size) return RG_ERR_BUFFER_TOO_SMALL;

  uint8_t* const bytes = (uint8_t*)buffer;
  const uint32_t sections = num_sections(contents);
  section_writer writer = {bytes, bytes + RG_HEADER_SIZE,
                           RG_HEADER_SIZE + RG_SECTION_ENTRY_SIZE * sections,
                           min_version_for_parts(contents)};
  write_sections(contents, &writer);
  write_header(bytes, writer.minor, size, sections);
  write_crcs(bytes, sections);

  rg_blob blob;
  return rg_blob_open(bytes, size, &blob);
}
