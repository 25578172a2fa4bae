/* What the blob says of how far a pixel may be trusted. */
#include "blob_checks.h"
#include "bytes.h"
#include "rg_blob.h"
#include "surface.h"

/* Whether a coordinate lies between the ends of the area. */
static int is_between(const uint8_t* ends, int32_t q16) {
  const uint32_t low_q16 = rg_load_u32(ends);
  return (uint32_t)q16 - low_q16 <= rg_load_u32(ends + 8) - low_q16;
}

int rg_is_valid(const rg_camera* camera, rg_pixel pixel) {
  if (!is_between(camera->grid, pixel.x_q16) ||
      !is_between(camera->grid + 4, pixel.y_q16))
    return 0;
  const uint8_t* const entry = rg_find_entry(camera->blob, RG_SECTION_MASK, 0);
  if (!entry) return 1;
  const uint8_t* const section = camera->blob + rg_load_u32(entry + 4);
  /* The area begins half a pixel outside the image at most. */
  const int shift = 16 + (section[4] & 15);
  const uint32_t column = ((uint32_t)pixel.x_q16 + 0x8000) >> shift;
  const uint32_t row = ((uint32_t)pixel.y_q16 + 0x8000) >> shift;
  uint32_t columns = rg_load_u16(section), rows = rg_load_u16(section + 2);
  /* The image's far edge belongs to the last cell. */
  columns -= 1;
  rows -= 1;
  const uint32_t cell = (row < rows ? row : rows) * (columns + 1) +
                        (column < columns ? column : columns);
  /* Masks are not checked on opening; whatever this is, it must lie inside. */
  const uint32_t at = rg_load_u32(section + 8) + (cell >> 3);
  return at < rg_load_u32(entry + 8) && ((section[at] >> (cell & 7)) & 1) != 0;
}

rg_status rg_uncertainty(const rg_camera* camera, rg_pixel pixel,
                         uint16_t* pixels_q12) {
  const uint8_t* const entry =
      rg_find_entry(camera->blob, RG_SECTION_UNCERTAINTY, 0);
  if (!entry) return RG_ERR_UNKNOWN;
  const uint8_t* const section = camera->blob + rg_load_u32(entry + 4);
  const int32_t pixels_q16[2] = {pixel.x_q16, pixel.y_q16};
  const uint32_t columns = rg_load_u16(section);
  rg_cell_position cells[2];
  for (uint32_t c = 0; c < 2; ++c) {
    if (!rg_find_on_axis(camera->grid + 4 * c, rg_load_u32(section + 4 + 4 * c),
                         rg_load_u16(section + 2 * c) - 2u, pixels_q16[c],
                         &cells[c]))
      return RG_ERR_OUTSIDE_AREA;
  }
  const uint32_t first =
      rg_load_u32(section + 12) + 2 * (cells[1].cell * columns + cells[0].cell);
  /* Weights of 8 bits: a value below 2^16 and both weights fill 32 bits. */
  const uint32_t tx_q8 = (uint32_t)cells[0].t_q30 >> 22;
  const uint32_t ty_q8 = (uint32_t)cells[1].t_q30 >> 22;
  uint32_t sum_q28 = 0x8000;
  for (uint32_t k = 0; k < 4; ++k) {
    /* Checked here, not on opening. */
    const uint32_t at = first + 2 * ((k & 1) + (k >> 1) * columns);
    if (at % 2 != 0 || at >= rg_load_u32(entry + 8)) return RG_ERR_UNCERTAINTY;
    const uint32_t value_q12 = rg_load_u16(section + at);
    if (value_q12 == RG_UNKNOWN_UNCERTAINTY) return RG_ERR_UNKNOWN;
    sum_q28 += value_q12 * ((k & 1) ? tx_q8 : 256 - tx_q8) *
               ((k >> 1) ? ty_q8 : 256 - ty_q8);
  }
  *pixels_q12 = (uint16_t)(sum_q28 >> 16);
  return RG_OK;
}
