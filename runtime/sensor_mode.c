/* Frames of other sensor modes than the calibrated one. */
#include "blob_checks.h"
#include "bytes.h"
#include "fixed_point.h"
#include "inverse.h"
#include "raygrid.h"
#include "rg_blob.h"

#define MAX_SCALE_Q16 (UINT32_C(64) << 16)
#define LIMIT_Q16 (INT32_C(1) << 30)

static int is_scale(uint32_t scale_q16) {
  return scale_q16 >= UINT32_C(1) << 10 && scale_q16 <= MAX_SCALE_Q16;
}

static int is_within_limit(int32_t q16) {
  return q16 < LIMIT_Q16 && q16 > -LIMIT_Q16;
}

static int32_t flip(int32_t q16, uint32_t size) {
  return (int32_t)((size - 1) << 16) - q16;
}

static int is_usable(const rg_mode* mode) {
  return mode->width - 1u < RG_MAX_IMAGE_SIZE &&
         mode->height - 1u < RG_MAX_IMAGE_SIZE && is_scale(mode->scale_x_q16) &&
         is_scale(mode->scale_y_q16) && is_within_limit(mode->offset_x_q16) &&
         is_within_limit(mode->offset_y_q16);
}

/* One axis: (pixel + 1/2) scale - 1/2 + offset, or 0 where that does not fit.
 */
static int scale_up(int32_t pixel_q16, uint32_t scale_q16, int32_t offset_q16,
                    int32_t* calibrated_q16) {
  uint32_t low;
  const int32_t from_edge = pixel_q16 + 0x8000;
  const int32_t high = rg_multiply_signed(from_edge, (int32_t)scale_q16, &low);
  if (high >= LIMIT_Q16 >> 16 || high <= -(LIMIT_Q16 >> 16)) return 0;
  *calibrated_q16 = rg_multiply_shift(from_edge, (int32_t)scale_q16, 16) -
                    0x8000 + offset_q16;
  return is_within_limit(*calibrated_q16);
}

rg_status rg_mode_to_calibrated(const rg_mode* mode, rg_pixel pixel,
                                rg_pixel* calibrated) {
  if (!is_usable(mode) || !is_within_limit(pixel.x_q16) ||
      !is_within_limit(pixel.y_q16))
    return RG_ERR_ARGUMENT;
  if (mode->flip_x) pixel.x_q16 = flip(pixel.x_q16, mode->width);
  if (mode->flip_y) pixel.y_q16 = flip(pixel.y_q16, mode->height);
  rg_pixel scaled;
  if (!is_within_limit(pixel.x_q16) || !is_within_limit(pixel.y_q16) ||
      !scale_up(pixel.x_q16, mode->scale_x_q16, mode->offset_x_q16,
                &scaled.x_q16) ||
      !scale_up(pixel.y_q16, mode->scale_y_q16, mode->offset_y_q16,
                &scaled.y_q16))
    return RG_ERR_ARGUMENT;
  *calibrated = scaled;
  return RG_OK;
}

/* (offset + 1/2) / scale - 1/2, or 0 where that does not fit. */
static int scale_down(int32_t offset_q16, uint32_t scale_q16, int32_t* q16) {
  if (!is_within_limit(offset_q16)) return 0;
  /* scale = D 2^(16 - zeros) with D in [1/2, 1); 1 / D in q29. */
  const int zeros = rg_leading_zeros(scale_q16);
  const int32_t r_q29 = rg_reciprocal(scale_q16 << zeros);
  const int shift = 45 - zeros; /* 23 to 36 */
  const int32_t from_edge = offset_q16 + 0x8000;
  const int32_t high_word = rg_multiply_high(from_edge, r_q29);
  if (shift > 32) {
    *q16 = ((high_word + (1 << (shift - 33))) >> (shift - 32)) - 0x8000;
    return 1;
  }
  const int32_t limit = LIMIT_Q16 >> (32 - shift);
  if (high_word >= limit || high_word <= -limit) return 0;
  *q16 =
      (shift == 32 ? high_word : rg_multiply_shift(from_edge, r_q29, shift)) -
      0x8000;
  return 1;
}

rg_status rg_mode_from_calibrated(const rg_mode* mode, rg_pixel calibrated,
                                  rg_pixel* pixel) {
  if (!is_usable(mode) || !is_within_limit(calibrated.x_q16) ||
      !is_within_limit(calibrated.y_q16))
    return RG_ERR_ARGUMENT;
  int32_t x_q16, y_q16;
  if (!scale_down(calibrated.x_q16 - mode->offset_x_q16, mode->scale_x_q16,
                  &x_q16) ||
      !scale_down(calibrated.y_q16 - mode->offset_y_q16, mode->scale_y_q16,
                  &y_q16))
    return RG_ERR_ARGUMENT;
  pixel->x_q16 = mode->flip_x ? flip(x_q16, mode->width) : x_q16;
  pixel->y_q16 = mode->flip_y ? flip(y_q16, mode->height) : y_q16;
  return RG_OK;
}

/* Whether the mode's pixels cover calibrated ones only, along one axis, but for
 * what a scale is rounded by. */
static int is_part(int32_t offset_q16, uint32_t scale_q16, uint32_t size,
                   uint32_t calibrated_size) {
  uint32_t low;
  if (offset_q16 < 0 || rg_multiply_unsigned(size, scale_q16, &low) != 0 ||
      low > 0x7fffffff)
    return 0;
  return (uint32_t)offset_q16 + low <= (calibrated_size << 16) + (size + 1) / 2;
}

/* An empty serial fits every camera. expected: RG_TEXT_SIZE bytes; not checked
 * on opening, so the last is taken for a zero whatever it is. */
static int is_serial(const char* expected, const char* serial) {
  if (!serial || expected[0] == 0) return 1;
  uint32_t i = 0;
  while (i < RG_TEXT_SIZE - 1 && expected[i] != 0 && expected[i] == serial[i])
    ++i;
  return expected[i] == serial[i];
}

rg_match_result rg_match(const rg_camera* camera, const rg_mode* mode,
                         uint16_t width, uint16_t height, const char* serial) {
  const uint8_t* const identity =
      camera->blob +
      rg_load_u32(rg_find_entry(camera->blob, RG_SECTION_CAMERA, 0) + 4);
  if (!is_serial((const char*)identity + 40, serial)) return RG_MATCH_NONE;
  if (!mode)
    return width == camera->width && height == camera->height ? RG_MATCH_EXACT
                                                              : RG_MATCH_NONE;
  if (!is_usable(mode) || width != mode->width || height != mode->height ||
      !is_part(mode->offset_x_q16, mode->scale_x_q16, width, camera->width) ||
      !is_part(mode->offset_y_q16, mode->scale_y_q16, height, camera->height))
    return RG_MATCH_NONE;
  const int is_same = width == camera->width && height == camera->height &&
                      mode->scale_x_q16 == 65536 &&
                      mode->scale_y_q16 == 65536 && !mode->flip_x &&
                      !mode->flip_y;
  return is_same ? RG_MATCH_EXACT : RG_MATCH_DERIVABLE;
}
