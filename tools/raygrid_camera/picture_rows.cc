#include "picture_rows.h"

#include <algorithm>
#include <cstring>

#include "frames/pixel_formats.h"

namespace raygrid {
namespace {

uint8_t Clamp(int value) {
  return static_cast<uint8_t>(std::clamp(value, 0, 255));
}

// YUV of BT.601 to RGB, in q8.
struct YuvToRgb {
  int black, luma, red_v, green_u, green_v, blue_u;

  void Put(int y, int u, int v, uint8_t* rgb) const {
    const int grey = luma * (y - black) + 128;
    u -= 128;
    v -= 128;
    rgb[0] = Clamp((grey + red_v * v) >> 8);
    rgb[1] = Clamp((grey - green_u * u - green_v * v) >> 8);
    rgb[2] = Clamp((grey + blue_u * u) >> 8);
  }
};

const YuvToRgb& ConversionOf(const StreamFormat& format) {
  static constexpr YuvToRgb kVideo = {16, 298, 409, 100, 208, 516};
  static constexpr YuvToRgb kFull = {0, 256, 359, 88, 183, 454};
  return format.is_full_range ? kFull : kVideo;
}

// A sample's upper 8 bits.
struct SampleRow {
  rg_sample_kind kind;
  int shift;
  const uint8_t* bytes;

  uint8_t operator[](uint32_t index) const {
    return static_cast<uint8_t>(rg_load_sample(kind, bytes, index) >> shift);
  }
};

const uint8_t* RowOf(const rg_image& image, int plane, uint32_t row) {
  return image.planes[plane].data + size_t{row} * image.planes[plane].stride;
}

SampleRow SamplesOf(const PixelFormatInfo& pixel_format, const rg_image& image,
                    uint32_t row) {
  rg_lattice lattice;
  rg_find_lattice(pixel_format.format, 0, &lattice);
  return {static_cast<rg_sample_kind>(lattice.kind), pixel_format.bits - 8,
          RowOf(image, 0, row)};
}

void ReadGreyRow(const SampleRow& samples, uint32_t width, uint8_t* rgb) {
  for (uint32_t x = 0; x < width; ++x)
    std::fill_n(rgb + size_t{3} * x, 3, samples[x]);
}

// Red, green and blue of 5, 6 and 5 bits; their high bits fill the low ones.
void ReadFieldsRow(const uint8_t* words, uint32_t width, uint8_t* rgb) {
  for (uint32_t x = 0; x < width; ++x, rgb += 3)
    for (uint32_t i = 0; i < 3; ++i) {
      const uint32_t bits = i == 1 ? 6 : 5;
      const uint32_t value = rg_load_sample(RG_SAMPLE_565, words, 4 * x + i);
      rgb[i] =
          static_cast<uint8_t>(value << (8 - bits) | value >> (2 * bits - 8));
    }
}

void ReadInterleavedRow(const StreamFormat& format, const rg_image& image,
                        uint32_t row, uint8_t* rgb) {
  const PixelFormatInfo& pixel_format = *format.pixel_format;
  const YuvToRgb& yuv = ConversionOf(format);
  const int step = pixel_format.format == RG_FORMAT_RGB24 ? 3 : 4;
  const uint8_t* pixel = RowOf(image, 0, row);
  const uint8_t* const order = pixel_format.order;
  for (uint32_t x = 0; x < image.width; ++x, pixel += step, rgb += 3) {
    if (pixel_format.model == ColourModel::kYuv)
      yuv.Put(pixel[order[0]], pixel[order[1]], pixel[order[2]], rgb);
    else
      for (int i = 0; i < 3; ++i) rgb[i] = pixel[order[i]];
  }
}

// YUYV and its like: pairs of pixels in 4 bytes.
void ReadPairedRow(const StreamFormat& format, const rg_image& image,
                   uint32_t row, uint8_t* rgb) {
  const PixelFormatInfo& pixel_format = *format.pixel_format;
  const YuvToRgb& yuv = ConversionOf(format);
  const uint8_t* pair = RowOf(image, 0, row);
  const uint8_t* const order = pixel_format.order;
  for (uint32_t x = 0; x < image.width; ++x, rgb += 3) {
    const uint8_t* const group = pair + size_t{4} * (x / 2);
    yuv.Put(group[order[0] + 2 * (x & 1)], group[order[1]], group[order[2]],
            rgb);
  }
}

void ReadPlanarRow(const StreamFormat& format, const rg_image& image,
                   uint32_t row, uint8_t* rgb) {
  const PixelFormatInfo& pixel_format = *format.pixel_format;
  const YuvToRgb& yuv = ConversionOf(format);
  const bool is_nv12 = pixel_format.format == RG_FORMAT_NV12;
  const uint8_t* const order = pixel_format.order;
  const uint8_t* const luma = RowOf(image, 0, row);
  const uint8_t* chroma[2];
  for (int i = 0; i < 2; ++i)
    chroma[i] = is_nv12 ? RowOf(image, 1, row / 2) + order[i + 1]
                        : RowOf(image, order[i + 1], row / 2);
  const uint32_t step = is_nv12 ? 2 : 1;
  for (uint32_t x = 0; x < image.width; ++x, rgb += 3)
    yuv.Put(luma[x], chroma[0][x / 2 * step], chroma[1][x / 2 * step], rgb);
}

void ReadBayerRow(const PixelFormatInfo& pixel_format, const rg_image& image,
                  uint32_t row, uint8_t* rgb) {
  const uint32_t top = row & ~1u;
  const SampleRow rows[2] = {SamplesOf(pixel_format, image, top),
                             SamplesOf(pixel_format, image, top + 1)};
  for (uint32_t x = 0; x < image.width; ++x, rgb += 3)
    for (int i = 0; i < 3; ++i) {
      const uint32_t place = pixel_format.order[i];
      rgb[i] = rows[place >> 1][(x & ~1u) + (place & 1)];
    }
}

}  // namespace

void ReadPictureRow(const StreamFormat& format, const rg_image& image,
                    uint32_t row, uint8_t* rgb) {
  const PixelFormatInfo& pixel_format = *format.pixel_format;
  switch (pixel_format.format) {
    case RG_FORMAT_RGB24:
    case RG_FORMAT_RGB32:
      return ReadInterleavedRow(format, image, row, rgb);
    case RG_FORMAT_RGB565:
      return ReadFieldsRow(RowOf(image, 0, row), image.width, rgb);
    case RG_FORMAT_YUYV:
    case RG_FORMAT_UYVY:
      return ReadPairedRow(format, image, row, rgb);
    case RG_FORMAT_NV12:
    case RG_FORMAT_YUV420:
      return ReadPlanarRow(format, image, row, rgb);
    default:
      if (pixel_format.model == ColourModel::kBayer)
        return ReadBayerRow(pixel_format, image, row, rgb);
      return ReadGreyRow(SamplesOf(pixel_format, image, row), image.width, rgb);
  }
}

rg_image MakePackedImage(const StreamFormat& format, const uint8_t* bytes) {
  rg_image image = {};
  image.format = format.pixel_format->format;
  image.width = format.width;
  image.height = format.height;
  for (int i = 0; i < format.num_planes; ++i) {
    image.planes[i].data = bytes;
    image.planes[i].stride = format.planes[i].row_bytes;
    bytes += size_t{format.planes[i].row_bytes} * format.planes[i].rows;
  }
  return image;
}

void CopyPlanes(const StreamFormat& format, const rg_image& image,
                uint8_t* bytes) {
  for (int i = 0; i < format.num_planes; ++i) {
    const PlaneLayout& plane = format.planes[i];
    for (uint32_t row = 0; row < plane.rows; ++row, bytes += plane.row_bytes)
      std::memcpy(bytes,
                  image.planes[i].data + size_t{row} * image.planes[i].stride,
                  plane.row_bytes);
  }
}

}  // namespace raygrid
