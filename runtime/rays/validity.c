/* The validity of pixels: the valid region stored in the blob. */
#include "blob_checks.h"
#include "bytes.h"
#include "rays/surface.h"
#include "rg_blob.h"

/* Whether a coordinate is within the area. axis: the grid for x, 4 bytes after
 * it for y. */
static int is_between(const uint8_t* axis, int32_t q16) {
  const uint32_t low_q16 = rg_load_u32(axis + RG_GRID_X0);
  return (uint32_t)q16 - low_q16 <= rg_load_u32(axis + RG_GRID_X1) - low_q16;
}

int rg_is_valid(const rg_camera* camera, rg_pixel pixel) {
  if (!is_between(camera->grid, pixel.x_q16) ||
      !is_between(camera->grid + 4, pixel.y_q16))
    return 0;
  const uint8_t* const entry = rg_find_entry(camera->blob, RG_SECTION_MASK, 0);
  if (!entry) return 1;
  const uint8_t* const section =
      camera->blob + rg_load_u32(entry + RG_ENTRY_OFFSET);
  /* The area extends at most half a pixel outside the image. */
  const int shift = 16 + (section[RG_MASK_CELL_LOG2] & 15);
  const uint32_t column = ((uint32_t)pixel.x_q16 + 0x8000) >> shift;
  const uint32_t row = ((uint32_t)pixel.y_q16 + 0x8000) >> shift;
  uint32_t columns = rg_load_u16(section + RG_MASK_COLUMNS);
  uint32_t rows = rg_load_u16(section + RG_MASK_ROWS);
  /* The image's far edge belongs to the last cell. */
  columns -= 1;
  rows -= 1;
  const uint32_t cell = (row < rows ? row : rows) * (columns + 1) +
                        (column < columns ? column : columns);
  /* Masks are not checked when opening; the offset must be checked here. */
  const uint32_t at = rg_load_u32(section + RG_MASK_DATA_OFFSET) + (cell >> 3);
  return at < rg_load_u32(entry + RG_ENTRY_SIZE) &&
         ((section[at] >> (cell & 7)) & 1) != 0;
}

rg_status rg_uncertainty(const rg_camera* camera, rg_pixel pixel,
                         uint16_t* pixels_q12) {
  const uint8_t* const entry =
      rg_find_entry(camera->blob, RG_SECTION_UNCERTAINTY, 0);
  if (!entry) return RG_ERR_UNKNOWN;
  const uint8_t* const section =
      camera->blob + rg_load_u32(entry + RG_ENTRY_OFFSET);
  const uint32_t columns = rg_load_u16(section + RG_UNCERTAINTY_COLUMNS);
  uint32_t x_q8 = 0, y_q8 = 0, first = 0;
  int32_t q16 = pixel.y_q16;
  for (int c = 1; c >= 0; --c, q16 = pixel.x_q16) {
    rg_cell_position position;
    if (!rg_find_on_axis(
            camera->grid + 4 * c,
            rg_load_u32(section + RG_UNCERTAINTY_SCALE_X + 4 * c),
            rg_load_u16(section + RG_UNCERTAINTY_COLUMNS + 2 * c) - 2u, q16,
            &position))
      return RG_ERR_OUTSIDE_AREA;
    first = first * columns + position.cell;
    y_q8 = x_q8;
    x_q8 = (uint32_t)position.t_q30 >> 22;
  }
  /* Checked here, not when opening the blob. */
  const uint32_t size = rg_load_u32(entry + RG_ENTRY_SIZE);
  const uint32_t at =
      rg_load_u32(section + RG_UNCERTAINTY_DATA_OFFSET) + 2 * first;
  if (at % 2 != 0 || at >= size || at + 2 * columns + 2 >= size)
    return RG_ERR_UNCERTAINTY;
  /* Bilinear; a value below 2^16 and weights of 8 bits fill 32 bits. */
  const uint8_t* values = section + at;
  uint32_t sum_q28 = 0x8000, weight_q8 = 256 - y_q8;
  for (int rows = 2; rows > 0; --rows, values += 2 * columns) {
    const uint32_t left_q12 = rg_load_u16(values);
    const uint32_t right_q12 = rg_load_u16(values + 2);
    if (left_q12 == RG_UNKNOWN_UNCERTAINTY ||
        right_q12 == RG_UNKNOWN_UNCERTAINTY)
      return RG_ERR_UNKNOWN;
    sum_q28 += weight_q8 * (256 * left_q12 + x_q8 * (right_q12 - left_q12));
    weight_q8 = y_q8;
  }
  *pixels_q12 = (uint16_t)(sum_q28 >> 16);
  return RG_OK;
}
