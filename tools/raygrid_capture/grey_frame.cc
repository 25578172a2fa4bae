#include "grey_frame.h"

#include <cstring>
#include <string>

#include "camera_error.h"
#include "rgb_rows.h"

namespace raygrid {
namespace {

bool IsPacked(const PixelFormatInfo& info) {
  return std::string(info.name).find("CSI2P") != std::string::npos;
}

void ConvertRowToLuma(const PixelFormatInfo& info, const uint8_t* row,
                      int width, uint8_t* grey) {
  const SampleChannel luma = FindChannel(info.format, info.order[0]);
  row += luma.first_sample;
  for (int x = 0; x < width; ++x) grey[x] = row[x * luma.component.sample_step];
}

// Stored in the processor's byte order, like all images in memory.
void WidenRow(const PixelFormatInfo& info, const uint8_t* row, int width,
              uint8_t* grey) {
  for (int x = 0; x < width; ++x) {
    const int value = row[2 * x] | row[2 * x + 1] << 8;
    const auto wide = static_cast<uint16_t>(value << (16 - info.bits));
    std::memcpy(grey + 2 * static_cast<size_t>(x), &wide, sizeof(wide));
  }
}

void MixColours(const uint8_t* rgb, int width, uint8_t* grey) {
  for (int x = 0; x < width; ++x, rgb += 3)
    grey[x] = static_cast<uint8_t>(
        (299 * rgb[0] + 587 * rgb[1] + 114 * rgb[2] + 500) / 1000);
}

}  // namespace

void RequireGrey(const PixelFormatInfo& pixel_format) {
  if (pixel_format.model != ColourModel::kBayer && !IsPacked(pixel_format))
    return;
  throw CameraError(CameraExit::kUsage,
                    std::string("--format: ") + pixel_format.name +
                        " has no full-resolution luma; use a format such as "
                        "YUYV, NV12, RGB888 or R8 (see raygrid-camera --list)");
}

Image ConvertToGrey(const StreamFormat& format, const rg_image& frame) {
  const PixelFormatInfo& info = *format.pixel_format;
  Image image;
  image.size = {format.width, format.height};
  image.sample_bytes = info.bits > 8 ? 2 : 1;
  image.pixels.resize(image.stride() * format.height);
  std::vector<uint8_t> rgb(size_t{3} * format.width);
  for (uint32_t y = 0; y < format.height; ++y) {
    const uint8_t* const row =
        frame.planes[0].data + size_t{y} * frame.planes[0].stride;
    uint8_t* const grey = &image.pixels[image.stride() * y];
    if (info.model == ColourModel::kRgb) {
      ReadRgbRow(format, frame, y, rgb.data());
      MixColours(rgb.data(), format.width, grey);
    } else if (info.bits > 8) {
      WidenRow(info, row, format.width, grey);
    } else {
      ConvertRowToLuma(info, row, format.width, grey);
    }
  }
  return image;
}

}  // namespace raygrid
