/* Frames of other sensor modes than the calibrated one. */
#include "blob_checks.h"
#include "bytes.h"
#include "fixed_point.h"
#include "raygrid.h"
#include "rays/inverse.h"
#include "rg_blob.h"

#define MIN_SCALE_Q16 (UINT32_C(1) << 10)
#define MAX_SCALE_Q16 (UINT32_C(64) << 16)
#define LIMIT_Q16 (UINT32_C(1) << 30)

typedef struct mode_axis {
  uint32_t size;
  int32_t offset_q16;
  uint32_t scale_q16;
  int is_flipped;
} mode_axis;

static void find_axes(const rg_mode* mode, mode_axis axes[2]) {
  axes[0].size = mode->width;
  axes[0].offset_q16 = mode->offset_x_q16;
  axes[0].scale_q16 = mode->scale_x_q16;
  axes[0].is_flipped = mode->flip_x != 0;
  axes[1].size = mode->height;
  axes[1].offset_q16 = mode->offset_y_q16;
  axes[1].scale_q16 = mode->scale_y_q16;
  axes[1].is_flipped = mode->flip_y != 0;
}

static int is_possible(const mode_axis* axis) {
  return axis->size - 1 < RG_MAX_IMAGE_SIZE &&
         axis->scale_q16 - MIN_SCALE_Q16 <= MAX_SCALE_Q16 - MIN_SCALE_Q16 &&
         rg_magnitude(axis->offset_q16) < LIMIT_Q16;
}

/* (q16 + 1/2) factor / 2^shift - 1/2, shift from 16 to 31; 0 where that does
 * not fit. */
static int scale_position(int32_t factor, int shift, int32_t* q16) {
  uint32_t low;
  const int32_t from_edge = *q16 + 0x8000;
  const int32_t high = rg_multiply_signed(from_edge, factor, &low);
  if (rg_magnitude(high) >> (shift - 2) != 0) return 0;
  *q16 = rg_multiply_shift(from_edge, factor, shift) - 0x8000;
  return 1;
}

/* Flips, scales and moves a coordinate to calibrated frames, or does so
 * backwards; 0 where that does not fit. */
static RG_INLINE int convert_axis(const mode_axis* axis, int is_to_calibrated,
                                  int32_t* q16) {
  const int32_t last_q16 = (int32_t)((axis->size - 1) << 16);
  int32_t at_q16 = *q16, factor = (int32_t)axis->scale_q16;
  int shift = 16;
  const uint32_t distance_q16 = rg_magnitude(at_q16);
  if (is_to_calibrated) {
    if (axis->is_flipped) at_q16 = rg_subtract(last_q16, at_q16);
  } else {
    at_q16 = rg_subtract(at_q16, axis->offset_q16);
    /* scale = D 2^(16 - zeros) with D in [1/2, 1); 1 / D in q29. */
    const int zeros = rg_leading_zeros(axis->scale_q16);
    factor = rg_reciprocal(axis->scale_q16 << zeros);
    shift = 45 - zeros; /* 23 to 36 */
    if (shift > 31) {   /* positions are then short enough for fewer bits */
      factor >>= shift - 31;
      shift = 31;
    }
  }
  if ((distance_q16 | rg_magnitude(at_q16)) >= LIMIT_Q16) return 0;
  if (!scale_position(factor, shift, &at_q16)) return 0;
  if (is_to_calibrated)
    at_q16 += axis->offset_q16;
  else
    at_q16 = axis->is_flipped ? last_q16 - at_q16 : at_q16;
  *q16 = at_q16;
  return rg_magnitude(at_q16) < LIMIT_Q16;
}

static rg_status convert(const rg_mode* mode, const rg_pixel* pixel,
                         rg_pixel* converted, int is_to_calibrated) {
  int32_t q16[2] = {pixel->x_q16, pixel->y_q16};
  mode_axis axes[2];
  find_axes(mode, axes);
  for (int c = 0; c < 2; ++c)
    if (!is_possible(&axes[c]) ||
        !convert_axis(&axes[c], is_to_calibrated, &q16[c]))
      return RG_ERR_ARGUMENT;
  converted->x_q16 = q16[0];
  converted->y_q16 = q16[1];
  return RG_OK;
}

rg_status rg_mode_to_calibrated(const rg_mode* mode, rg_pixel pixel,
                                rg_pixel* calibrated) {
  return convert(mode, &pixel, calibrated, 1);
}

rg_status rg_mode_from_calibrated(const rg_mode* mode, rg_pixel calibrated,
                                  rg_pixel* pixel) {
  return convert(mode, &calibrated, pixel, 0);
}

/* That of frames as calibrated. */
static void set_calibrated_mode(const rg_camera* camera, rg_mode* mode) {
  rg_calibrated_size(camera, &mode->width, &mode->height);
  mode->offset_x_q16 = mode->offset_y_q16 = 0;
  mode->scale_x_q16 = mode->scale_y_q16 = 65536;
  mode->flip_x = mode->flip_y = 0;
}

rg_status rg_remap_mode(const rg_camera* camera, rg_mode* mode) {
  const uint8_t* const section = camera->remap;
  if (!section) return RG_ERR_NO_REMAP;
  if (!rg_has_view(section) || section[RG_VIEW_MODE] == 0) {
    set_calibrated_mode(camera, mode);
    return RG_OK;
  }
  const uint8_t* const fields =
      rg_find_mode(camera->blob, section[RG_VIEW_MODE]);
  if (!fields) return RG_ERR_MODE;
  mode->width = rg_load_u16(fields + RG_MODE_WIDTH);
  mode->height = rg_load_u16(fields + RG_MODE_HEIGHT);
  mode->offset_x_q16 = rg_load_i32(fields + RG_MODE_OFFSET_X);
  mode->offset_y_q16 = rg_load_i32(fields + RG_MODE_OFFSET_Y);
  mode->scale_x_q16 = rg_load_u32(fields + RG_MODE_SCALE_X);
  mode->scale_y_q16 = rg_load_u32(fields + RG_MODE_SCALE_Y);
  mode->flip_x = fields[RG_MODE_FLIP_X];
  mode->flip_y = fields[RG_MODE_FLIP_Y];
  return RG_OK;
}

/* ---- Matches ------------------------------------------------------------- */

/* Whether the mode's pixels cover calibrated ones only, along one axis, but for
 * what a scale is rounded by. */
static int is_part(const mode_axis* axis, uint32_t calibrated_size) {
  uint32_t low;
  const uint32_t high = rg_multiply_unsigned(axis->size, axis->scale_q16, &low);
  if (high != 0 || ((low | (uint32_t)axis->offset_q16) >> 31) != 0) return 0;
  return (uint32_t)axis->offset_q16 + low <=
         (calibrated_size << 16) + (axis->size + 1) / 2;
}

/* Whether a mode shows a part of the calibrated frames. */
static int is_part_of(const mode_axis mode[2], const mode_axis calibrated[2]) {
  for (int c = 0; c < 2; ++c)
    if (!is_possible(&mode[c]) || !is_part(&mode[c], calibrated[c].size))
      return 0;
  return 1;
}

/* Whether numbers are the same but for what they were rounded by. */
static int are_near(uint32_t a, uint32_t b) { return a - b + 1 <= 2; }

static int are_same(const mode_axis a[2], const mode_axis b[2]) {
  for (int c = 0; c < 2; ++c)
    if (a[c].size != b[c].size || a[c].is_flipped != b[c].is_flipped ||
        !are_near((uint32_t)a[c].offset_q16, (uint32_t)b[c].offset_q16) ||
        !are_near(a[c].scale_q16, b[c].scale_q16))
      return 0;
  return 1;
}

/* The first table that undistorts frames of a mode, or RG_NO_TABLE. */
static uint32_t find_table(const rg_camera* camera, const mode_axis mode[2]) {
  rg_camera with_table;
  with_table.blob = camera->blob;
  with_table.identity = camera->identity;
  for (uint32_t k = 0;; ++k) {
    rg_mode of_table;
    mode_axis axes[2];
    const rg_status status = rg_select_remap(&with_table, k);
    if (status == RG_ERR_NO_REMAP) return RG_NO_TABLE;
    if (status != RG_OK || rg_remap_mode(&with_table, &of_table) != RG_OK)
      continue;
    find_axes(&of_table, axes);
    if (are_same(mode, axes) && !rg_distorts(with_table.remap)) return k;
  }
}

/* An empty serial fits every camera. expected: RG_TEXT_SIZE bytes; not checked
 * on opening, so the last is taken for a zero whatever it is. */
static int is_serial(const uint8_t* expected, const char* serial) {
  if (!serial || expected[0] == 0) return 1;
  for (uint32_t i = 0; expected[i] == (uint8_t)serial[i]; ++i)
    if (expected[i] == 0 || i == RG_TEXT_SIZE - 1) return 1;
  return 0;
}

rg_match_result rg_match(const rg_camera* camera, const rg_mode* mode,
                         uint16_t width, uint16_t height, const char* serial,
                         uint32_t* remap) {
  rg_mode calibrated;
  mode_axis calibrated_axes[2], axes[2];
  uint32_t table = RG_NO_TABLE;
  rg_match_result result = RG_MATCH_NONE;
  set_calibrated_mode(camera, &calibrated);
  find_axes(&calibrated, calibrated_axes);
  find_axes(mode ? mode : &calibrated, axes);
  if (axes[0].size == width && axes[1].size == height &&
      is_part_of(axes, calibrated_axes) &&
      is_serial(camera->identity + RG_CAMERA_SERIAL, serial)) {
    table = find_table(camera, axes);
    result = are_same(axes, calibrated_axes) ? RG_MATCH_EXACT
             : table != RG_NO_TABLE          ? RG_MATCH_MODE
                                             : RG_MATCH_DERIVABLE;
  }
  if (remap) *remap = table;
  return result;
}
