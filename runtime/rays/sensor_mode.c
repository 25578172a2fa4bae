/* Frames of sensor modes other than the calibrated one. */
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

/* Reads axis c of a mode; 0 if it is invalid. */
static int compute_mode_axis(const rg_mode* mode, int c, mode_axis* axis) {
  axis->size = c == 0 ? mode->width : mode->height;
  axis->offset_q16 = c == 0 ? mode->offset_x_q16 : mode->offset_y_q16;
  axis->scale_q16 = c == 0 ? mode->scale_x_q16 : mode->scale_y_q16;
  axis->is_flipped = c == 0 ? mode->flip_x : mode->flip_y;
  return axis->size - 1 < RG_MAX_IMAGE_SIZE &&
         axis->scale_q16 - MIN_SCALE_Q16 <= MAX_SCALE_Q16 - MIN_SCALE_Q16 &&
         rg_magnitude(axis->offset_q16) < LIMIT_Q16;
}

/* (q16 + 1/2) factor / 2^shift - 1/2, shift from 16 to 31; 0 on overflow. */
static int scale_position(int32_t factor, int shift, int32_t* q16) {
  uint32_t low;
  const int32_t from_edge = *q16 + 0x8000;
  const int32_t high = rg_multiply_signed(from_edge, factor, &low);
  if (rg_magnitude(high) >> (shift - 2) != 0) return 0;
  *q16 = rg_multiply_shift(from_edge, factor, shift) - 0x8000;
  return 1;
}

/* Flips, scales and shifts a coordinate to calibrated frames, or the inverse; 0
 * on overflow. */
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
    if (shift > 31) {   /* positions then have enough free bits */
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
  for (int c = 0; c < 2; ++c) {
    mode_axis axis;
    if (!compute_mode_axis(mode, c, &axis) ||
        !convert_axis(&axis, is_to_calibrated, &q16[c]))
      return RG_ERR_ARGUMENT;
  }
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

/* ---- Modes of tables ----------------------------------------------------- */

/* Reads the mode of a table's real frames; NULL: frames as calibrated.
 * RG_ERR_MODE if the blob lacks it. */
static rg_status read_mode(const rg_camera* camera, const uint8_t* section,
                           rg_mode* mode) {
  if (!section || !rg_has_view(section) || section[RG_VIEW_MODE] == 0) {
    rg_calibrated_size(camera, &mode->width, &mode->height);
    mode->offset_x_q16 = mode->offset_y_q16 = 0;
    mode->scale_x_q16 = mode->scale_y_q16 = 65536;
    mode->flip_x = mode->flip_y = 0;
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

rg_status rg_remap_mode(const rg_camera* camera, rg_mode* mode) {
  if (!camera->remap) return RG_ERR_NO_REMAP;
  return read_mode(camera, camera->remap, mode);
}

/* ---- Matches ------------------------------------------------------------- */

/* Whether the mode covers only calibrated pixels along one axis, within the
 * rounding of its scale. */
static int is_within(const mode_axis* axis, uint32_t calibrated_size) {
  uint32_t low;
  const uint32_t high = rg_multiply_unsigned(axis->size, axis->scale_q16, &low);
  if (high != 0 || ((low | (uint32_t)axis->offset_q16) >> 31) != 0) return 0;
  return (uint32_t)axis->offset_q16 + low <=
         (calibrated_size << 16) + (axis->size + 1) / 2;
}

/* Whether a mode shows a part of the calibrated frames. */
static int is_part_of_frames(const rg_mode* mode, const uint8_t* identity) {
  for (int c = 0; c < 2; ++c) {
    mode_axis axis;
    const uint32_t size = rg_load_u16(identity + RG_CAMERA_WIDTH + 2 * c);
    if (!compute_mode_axis(mode, c, &axis) || !is_within(&axis, size)) return 0;
  }
  return 1;
}

/* Whether numbers are equal within their rounding. */
static int are_near(uint32_t a, uint32_t b) { return a - b + 1 <= 2; }

static int is_same_mode(const rg_mode* a, const rg_mode* b) {
  return a->width == b->width && a->height == b->height &&
         !a->flip_x == !b->flip_x && !a->flip_y == !b->flip_y &&
         are_near((uint32_t)a->offset_x_q16, (uint32_t)b->offset_x_q16) &&
         are_near((uint32_t)a->offset_y_q16, (uint32_t)b->offset_y_q16) &&
         are_near(a->scale_x_q16, b->scale_x_q16) &&
         are_near(a->scale_y_q16, b->scale_y_q16);
}

/* The first table that undistorts frames of a mode, or RG_NO_TABLE. */
static uint32_t find_table(const rg_camera* camera, const rg_mode* mode) {
  const uint8_t* entry;
  for (uint32_t k = 0;
       (entry = rg_find_entry(camera->blob, RG_SECTION_REMAP, k)) != 0; ++k) {
    const uint8_t* const section =
        camera->blob + rg_load_u32(entry + RG_ENTRY_OFFSET);
    const uint32_t size = rg_load_u32(entry + RG_ENTRY_SIZE);
    const uint32_t source_size =
        rg_source_size(section, size, rg_camera_size(camera->blob));
    rg_mode of_table;
    if (rg_check_remap(section, size, source_size) == RG_OK &&
        read_mode(camera, section, &of_table) == RG_OK &&
        is_same_mode(mode, &of_table) && !rg_distorts(section))
      return k;
  }
  return RG_NO_TABLE;
}

/* Whether a serial matches; an empty one always does. expected: RG_TEXT_SIZE
 * bytes; not checked when opening, so the last is assumed to be zero. */
static int is_serial(const uint8_t* expected, const char* serial) {
  if (!serial || expected[0] == 0) return 1;
  for (uint32_t i = 0; expected[i] == (uint8_t)serial[i]; ++i)
    if (expected[i] == 0 || i == RG_TEXT_SIZE - 1) return 1;
  return 0;
}

rg_match_result rg_match(const rg_camera* camera, const rg_mode* mode,
                         uint16_t width, uint16_t height, const char* serial,
                         uint32_t* remap) {
  const uint8_t* const identity = rg_find_identity(camera->blob);
  rg_mode calibrated;
  uint32_t table = RG_NO_TABLE;
  rg_match_result result = RG_MATCH_NONE;
  read_mode(camera, 0, &calibrated);
  if (!mode) mode = &calibrated;
  if (mode->width == width && mode->height == height &&
      is_part_of_frames(mode, identity) &&
      is_serial(identity + RG_CAMERA_SERIAL, serial)) {
    table = find_table(camera, mode);
    result = is_same_mode(mode, &calibrated) ? RG_MATCH_EXACT
             : table != RG_NO_TABLE          ? RG_MATCH_MODE
                                             : RG_MATCH_DERIVABLE;
  }
  if (remap) *remap = table;
  return result;
}
