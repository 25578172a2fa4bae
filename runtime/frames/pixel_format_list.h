/* Written by tools/pixel_formats from formats/pixel_formats.toml; not for editing. */
/* clang-format off */
#ifndef RAYGRID_PIXEL_FORMAT_LIST_H
#define RAYGRID_PIXEL_FORMAT_LIST_H

/* X(plane, first sample, step, channels, lx, ly, hx, hy, first row, row step) */
#define RG_COMPONENTS(X) \
  X(0, 0, 3, 3, 0, 0, 0, 0, 0, 1) \
  X(0, 0, 4, 4, 0, 0, 0, 0, 0, 1) \
  X(0, 0, 2, 1, 0, 0, 0, 0, 0, 1) \
  X(0, 1, 4, 1, 1, 0, 1, 0, 0, 1) \
  X(0, 3, 4, 1, 1, 0, 1, 0, 0, 1) \
  X(0, 1, 2, 1, 0, 0, 0, 0, 0, 1) \
  X(0, 0, 4, 1, 1, 0, 1, 0, 0, 1) \
  X(0, 2, 4, 1, 1, 0, 1, 0, 0, 1) \
  X(0, 0, 1, 1, 0, 0, 0, 0, 0, 1) \
  X(1, 0, 2, 2, 1, 1, 1, 1, 0, 1) \
  X(0, 0, 1, 1, 0, 0, 0, 0, 0, 1) \
  X(1, 0, 1, 1, 1, 1, 1, 1, 0, 1) \
  X(2, 0, 1, 1, 1, 1, 1, 1, 0, 1) \
  X(0, 0, 2, 1, 1, 1, 0, 0, 0, 2) \
  X(0, 1, 2, 1, 1, 1, 2, 0, 0, 2) \
  X(0, 0, 2, 1, 1, 1, 0, 2, 1, 2) \
  X(0, 1, 2, 1, 1, 1, 2, 2, 1, 2) \
  X(0, 0, 4, 1, 0, 0, 0, 0, 0, 1) \
  X(0, 1, 4, 1, 0, 0, 0, 0, 0, 1) \
  X(0, 2, 4, 1, 0, 0, 0, 0, 0, 1)

/* X(name, kind of samples, first component, number of components, whether rows come in
 * pairs, of each plane {bits per image pixel, image rows per row}) */
#define RG_PIXEL_FORMATS(X) \
  X(GREY8, RG_SAMPLE_8, 10, 1, 0, {8, 1}) \
  X(GREY16, RG_SAMPLE_16, 10, 1, 0, {16, 1}) \
  X(GREY10P, RG_SAMPLE_10P, 10, 1, 0, {10, 1}) \
  X(GREY12P, RG_SAMPLE_12P, 10, 1, 0, {12, 1}) \
  X(RGB24, RG_SAMPLE_8, 0, 1, 0, {24, 1}) \
  X(RGB32, RG_SAMPLE_8, 1, 1, 0, {32, 1}) \
  X(YUYV, RG_SAMPLE_8, 2, 3, 0, {16, 1}) \
  X(UYVY, RG_SAMPLE_8, 5, 3, 0, {16, 1}) \
  X(NV12, RG_SAMPLE_8, 8, 2, 1, {8, 1}, {8, 2}) \
  X(YUV420, RG_SAMPLE_8, 10, 3, 1, {8, 1}, {4, 2}, {4, 2}) \
  X(BAYER8, RG_SAMPLE_8, 13, 4, 1, {8, 1}) \
  X(BAYER16, RG_SAMPLE_16, 13, 4, 1, {16, 1}) \
  X(BAYER10P, RG_SAMPLE_10P, 13, 4, 1, {10, 1}) \
  X(BAYER12P, RG_SAMPLE_12P, 13, 4, 1, {12, 1}) \
  X(RGB565, RG_SAMPLE_565, 17, 3, 0, {16, 1})

/* X(kind of samples, bits from one of them to the next) */
#define RG_SAMPLE_BITS(X) \
  X(RG_SAMPLE_8, 8) \
  X(RG_SAMPLE_10P, 10) \
  X(RG_SAMPLE_12P, 12) \
  X(RG_SAMPLE_16, 16) \
  X(RG_SAMPLE_565, 4)

#endif
