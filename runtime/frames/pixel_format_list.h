/* Written by tools/pixel_formats from formats/pixel_formats.toml; not for editing. Users define the macro
 * that a list calls. */
/* clang-format off */
#ifndef RAYGRID_PIXEL_FORMAT_LIST_H
#define RAYGRID_PIXEL_FORMAT_LIST_H

/* RG_COMPONENT(plane, first sample, step, channels, lx, ly, hx, hy, first row, row step) */
#define RG_COMPONENTS \
  RG_COMPONENT(0, 0, 3, 3, 0, 0, 0, 0, 0, 1) \
  RG_COMPONENT(0, 0, 4, 4, 0, 0, 0, 0, 0, 1) \
  RG_COMPONENT(0, 0, 2, 1, 0, 0, 0, 0, 0, 1) \
  RG_COMPONENT(0, 1, 4, 1, 1, 0, 1, 0, 0, 1) \
  RG_COMPONENT(0, 3, 4, 1, 1, 0, 1, 0, 0, 1) \
  RG_COMPONENT(0, 1, 2, 1, 0, 0, 0, 0, 0, 1) \
  RG_COMPONENT(0, 0, 4, 1, 1, 0, 1, 0, 0, 1) \
  RG_COMPONENT(0, 2, 4, 1, 1, 0, 1, 0, 0, 1) \
  RG_COMPONENT(0, 0, 1, 1, 0, 0, 0, 0, 0, 1) \
  RG_COMPONENT(1, 0, 2, 2, 1, 1, 1, 1, 0, 1) \
  RG_COMPONENT(0, 0, 1, 1, 0, 0, 0, 0, 0, 1) \
  RG_COMPONENT(1, 0, 1, 1, 1, 1, 1, 1, 0, 1) \
  RG_COMPONENT(2, 0, 1, 1, 1, 1, 1, 1, 0, 1) \
  RG_COMPONENT(0, 0, 2, 1, 1, 1, 0, 0, 0, 2) \
  RG_COMPONENT(0, 1, 2, 1, 1, 1, 2, 0, 0, 2) \
  RG_COMPONENT(0, 0, 2, 1, 1, 1, 0, 2, 1, 2) \
  RG_COMPONENT(0, 1, 2, 1, 1, 1, 2, 2, 1, 2) \
  RG_COMPONENT(0, 0, 4, 1, 0, 0, 0, 0, 0, 1) \
  RG_COMPONENT(0, 1, 4, 1, 0, 0, 0, 0, 0, 1) \
  RG_COMPONENT(0, 2, 4, 1, 0, 0, 0, 0, 0, 1)

/* RG_PIXEL_FORMAT(name, kind of samples, first component, number of components,
 * whether rows come in pairs, of each plane {bits per image pixel, image rows per row}) */
#define RG_PIXEL_FORMATS \
  RG_PIXEL_FORMAT(GREY8, RG_SAMPLE_8, 10, 1, 0, {8, 1}) \
  RG_PIXEL_FORMAT(GREY16, RG_SAMPLE_16, 10, 1, 0, {16, 1}) \
  RG_PIXEL_FORMAT(GREY10P, RG_SAMPLE_10P, 10, 1, 0, {10, 1}) \
  RG_PIXEL_FORMAT(GREY12P, RG_SAMPLE_12P, 10, 1, 0, {12, 1}) \
  RG_PIXEL_FORMAT(RGB24, RG_SAMPLE_8, 0, 1, 0, {24, 1}) \
  RG_PIXEL_FORMAT(RGB32, RG_SAMPLE_8, 1, 1, 0, {32, 1}) \
  RG_PIXEL_FORMAT(YUYV, RG_SAMPLE_8, 2, 3, 0, {16, 1}) \
  RG_PIXEL_FORMAT(UYVY, RG_SAMPLE_8, 5, 3, 0, {16, 1}) \
  RG_PIXEL_FORMAT(NV12, RG_SAMPLE_8, 8, 2, 1, {8, 1}, {8, 2}) \
  RG_PIXEL_FORMAT(YUV420, RG_SAMPLE_8, 10, 3, 1, {8, 1}, {4, 2}, {4, 2}) \
  RG_PIXEL_FORMAT(BAYER8, RG_SAMPLE_8, 13, 4, 1, {8, 1}) \
  RG_PIXEL_FORMAT(BAYER16, RG_SAMPLE_16, 13, 4, 1, {16, 1}) \
  RG_PIXEL_FORMAT(BAYER10P, RG_SAMPLE_10P, 13, 4, 1, {10, 1}) \
  RG_PIXEL_FORMAT(BAYER12P, RG_SAMPLE_12P, 13, 4, 1, {12, 1}) \
  RG_PIXEL_FORMAT(RGB565, RG_SAMPLE_565, 17, 3, 0, {16, 1})

/* RG_SAMPLE_KIND(kind, bits from one sample to the next) */
#define RG_SAMPLE_KINDS \
  RG_SAMPLE_KIND(RG_SAMPLE_8, 8) \
  RG_SAMPLE_KIND(RG_SAMPLE_10P, 10) \
  RG_SAMPLE_KIND(RG_SAMPLE_12P, 12) \
  RG_SAMPLE_KIND(RG_SAMPLE_16, 16) \
  RG_SAMPLE_KIND(RG_SAMPLE_565, 4)

#endif
