#include "rgb_rows.h"

#include <algorithm>
#include <cstring>

#include "kernels/samples.h"

namespace raygrid {
namespace {

uint8_t Clamp(int value) {
  return static_cast<uint8_t>(std::clamp(value, 0, 255));
}

// Coefficients of BT.601 from YUV to RGB, in q8.
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

const YuvToRgb& GetConversion(const StreamFormat& format) {
  static constexpr YuvToRgb kVideo = {16, 298, 409, 100, 208, 516};
  static constexpr YuvToRgb kFull = {0, 256, 359, 88, 183, 454};
  return format.is_full_range ? kFull : kVideo;
}

// Converts a sample from the given number of bits to 8; shorter samples repeat
// their high bits.
uint8_t ScaleToByte(uint32_t sample, int bits) {
  return static_cast<uint8_t>(bits >= 8 ? sample >> (bits - 8)
                                        : sample << (8 - bits) |
                                              sample >> (2 * bits - 8));
}

// Returns the number of bits of the channel's samples.
int GetBits(const PixelFormatInfo& pixel_format, const SampleChannel& channel) {
  if (channel.component.kind != RG_SAMPLE_565) return pixel_format.bits;
  return rg_field_mask(channel.first_sample) == 31 ? 5 : 6;
}

// Writes every third byte.
void ReadChannel(const PixelFormatInfo& pixel_format, const rg_image& image,
                 uint32_t index, uint32_t row, uint8_t* rgb) {
  const SampleChannel channel = FindChannel(pixel_format.format, index);
  const rg_component& component = channel.component;
  const auto& plane = image.planes[component.plane];
  const uint32_t plane_row =
      (row >> component.log2[1]) * component.row_step + component.first_row;
  const uint8_t* const bytes = plane.data + size_t{plane_row} * plane.stride;
  const uint32_t shift = component.log2[0], step = component.sample_step;
  const uint32_t first = channel.first_sample;
  if (component.kind == RG_SAMPLE_8) {
    for (uint32_t x = 0; x < image.width; ++x)
      rgb[size_t{3} * x] = bytes[first + (x >> shift) * step];
    return;
  }
  const int bits = GetBits(pixel_format, channel);
  for (uint32_t x = 0; x < image.width; ++x)
    rgb[size_t{3} * x] = ScaleToByte(
        rg_load_sample(component.kind, bytes, first + (x >> shift) * step),
        bits);
}

}  // namespace

void ReadRgbRow(const StreamFormat& format, const rg_image& image, uint32_t row,
                uint8_t* rgb) {
  const PixelFormatInfo& pixel_format = *format.pixel_format;
  const bool is_grey = pixel_format.model == ColourModel::kGrey;
  for (int i = 0; i < (is_grey ? 1 : 3); ++i)
    ReadChannel(pixel_format, image, pixel_format.order[i], row, rgb + i);
  const YuvToRgb& yuv = GetConversion(format);
  for (uint32_t x = 0; x < image.width; ++x, rgb += 3) {
    if (is_grey) rgb[1] = rgb[2] = rgb[0];
    if (pixel_format.model == ColourModel::kYuv)
      yuv.Put(rgb[0], rgb[1], rgb[2], rgb);
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
