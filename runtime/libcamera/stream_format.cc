#include "stream_format.h"

#include <algorithm>
#include <cstring>

#include "camera_error.h"
#include "frames/pixel_formats.h"
#include "rg_blob.h"

namespace raygrid {
namespace {

constexpr ColourModel kGrey = ColourModel::kGrey, kRgb = ColourModel::kRgb,
                      kYuv = ColourModel::kYuv, kBayer = ColourModel::kBayer;

// DRM's names, which libcamera has, say the order in a little-endian word:
// RGB888 is blue, green, red in memory.
constexpr PixelFormatInfo kFormats[] = {
    {"R8", RG_FORMAT_GREY8, kGrey, 8, {}},
    {"R10", RG_FORMAT_GREY16, kGrey, 10, {}},
    {"R12", RG_FORMAT_GREY16, kGrey, 12, {}},
    {"R14", RG_FORMAT_GREY16, kGrey, 14, {}},
    {"R16", RG_FORMAT_GREY16, kGrey, 16, {}},
    {"R10_CSI2P", RG_FORMAT_GREY10P, kGrey, 10, {}},
    {"R12_CSI2P", RG_FORMAT_GREY12P, kGrey, 12, {}},
    {"RGB888", RG_FORMAT_RGB24, kRgb, 8, {2, 1, 0}},
    {"BGR888", RG_FORMAT_RGB24, kRgb, 8, {0, 1, 2}},
    {"XRGB8888", RG_FORMAT_RGB32, kRgb, 8, {2, 1, 0}},
    {"ARGB8888", RG_FORMAT_RGB32, kRgb, 8, {2, 1, 0}},
    {"XBGR8888", RG_FORMAT_RGB32, kRgb, 8, {0, 1, 2}},
    {"ABGR8888", RG_FORMAT_RGB32, kRgb, 8, {0, 1, 2}},
    {"RGBX8888", RG_FORMAT_RGB32, kRgb, 8, {3, 2, 1}},
    {"RGBA8888", RG_FORMAT_RGB32, kRgb, 8, {3, 2, 1}},
    {"BGRX8888", RG_FORMAT_RGB32, kRgb, 8, {1, 2, 3}},
    {"BGRA8888", RG_FORMAT_RGB32, kRgb, 8, {1, 2, 3}},
    {"XVUY8888", RG_FORMAT_RGB32, kYuv, 8, {0, 1, 2}},
    {"AVUY8888", RG_FORMAT_RGB32, kYuv, 8, {0, 1, 2}},
    {"RGB565", RG_FORMAT_RGB565, kRgb, 8, {0, 1, 2}},
    {"YUYV", RG_FORMAT_YUYV, kYuv, 8, {0, 1, 3}},
    {"YVYU", RG_FORMAT_YUYV, kYuv, 8, {0, 3, 1}},
    {"UYVY", RG_FORMAT_UYVY, kYuv, 8, {1, 0, 2}},
    {"VYUY", RG_FORMAT_UYVY, kYuv, 8, {1, 2, 0}},
    {"NV12", RG_FORMAT_NV12, kYuv, 8, {0, 0, 1}},
    {"NV21", RG_FORMAT_NV12, kYuv, 8, {0, 1, 0}},
    {"YUV420", RG_FORMAT_YUV420, kYuv, 8, {0, 1, 2}},
    {"YVU420", RG_FORMAT_YUV420, kYuv, 8, {0, 2, 1}},
#define RAYGRID_BAYER(suffix, format, bits)                \
  {"SRGGB" suffix, format, kBayer, bits, {0, 1, 3}},       \
      {"SGRBG" suffix, format, kBayer, bits, {1, 0, 2}},   \
      {"SGBRG" suffix, format, kBayer, bits, {2, 0, 1}}, { \
    "SBGGR" suffix, format, kBayer, bits, { 3, 1, 0 }      \
  }
    RAYGRID_BAYER("8", RG_FORMAT_BAYER8, 8),
    RAYGRID_BAYER("10", RG_FORMAT_BAYER16, 10),
    RAYGRID_BAYER("12", RG_FORMAT_BAYER16, 12),
    RAYGRID_BAYER("14", RG_FORMAT_BAYER16, 14),
    RAYGRID_BAYER("16", RG_FORMAT_BAYER16, 16),
    RAYGRID_BAYER("10_CSI2P", RG_FORMAT_BAYER10P, 10),
    RAYGRID_BAYER("12_CSI2P", RG_FORMAT_BAYER12P, 12),
#undef RAYGRID_BAYER
};

// Chroma planes have half the rows; those of YUV420 half the stride too.
PlaneLayout LayOutPlane(const rg_lattice& lattice, uint32_t width,
                        uint32_t height, uint32_t first_stride) {
  PlaneLayout layout;
  layout.row_bytes = rg_plane_row_bytes(&lattice, width);
  // Lattices of a Bayer plane share its rows.
  layout.rows = lattice.row_step == 1 ? height >> lattice.log2[1] : height;
  const bool is_half_stride = lattice.plane != 0 && lattice.num_channels == 1;
  layout.stride = is_half_stride ? first_stride / 2 : first_stride;
  return layout;
}

}  // namespace

const PixelFormatInfo* FindPixelFormat(const std::string& name) {
  for (const PixelFormatInfo& format : kFormats)
    if (name == format.name) return &format;
  return nullptr;
}

std::vector<std::string> PixelFormatNames() {
  std::vector<std::string> names;
  for (const PixelFormatInfo& format : kFormats) names.push_back(format.name);
  return names;
}

uint32_t StreamFormat::packed_size() const {
  uint32_t size = 0;
  for (int i = 0; i < num_planes; ++i)
    size += planes[i].row_bytes * planes[i].rows;
  return size;
}

StreamFormat MakeStreamFormat(const PixelFormatInfo& pixel_format,
                              uint32_t width, uint32_t height,
                              uint32_t stride) {
  StreamFormat result = {};
  result.pixel_format = &pixel_format;
  const std::string text = std::to_string(width) + "x" +
                           std::to_string(height) + " " + pixel_format.name;
  const CameraError bad_size(
      CameraExit::kInput,
      text + ": not a size of that format; choose another with --size");
  if (width == 0 || height == 0 || width > RG_MAX_IMAGE_SIZE ||
      height > RG_MAX_IMAGE_SIZE)
    throw bad_size;
  result.width = static_cast<uint16_t>(width);
  result.height = static_cast<uint16_t>(height);
  rg_lattice lattice;
  for (uint32_t i = 0; rg_find_lattice(pixel_format.format, i, &lattice); ++i) {
    const uint32_t row_bytes = rg_plane_row_bytes(&lattice, width);
    if (row_bytes == 0 || (height & ((1u << lattice.log2[1]) - 1)) != 0)
      throw bad_size;
    if (lattice.plane == 0 && stride == 0) stride = row_bytes;
    result.planes[lattice.plane] = LayOutPlane(lattice, width, height, stride);
    result.num_planes = std::max(result.num_planes, lattice.plane + 1);
  }
  for (int i = 0; i < result.num_planes; ++i)
    if (result.planes[i].stride < result.planes[i].row_bytes ||
        result.planes[i].stride > 16 * RG_MAX_IMAGE_SIZE)
      throw CameraError(CameraExit::kInput,
                        text + ": the camera's stride of " +
                            std::to_string(stride) +
                            " bytes does not fit; choose another format");
  return result;
}

rg_image MakeImage(const StreamFormat& format, const uint8_t* const planes[3]) {
  rg_image image = {};
  image.format = format.pixel_format->format;
  image.width = format.width;
  image.height = format.height;
  for (int i = 0; i < format.num_planes; ++i) {
    image.planes[i].data = planes[i];
    image.planes[i].stride = format.planes[i].stride;
  }
  return image;
}

void SetBlackBorder(const StreamFormat& format, rg_target* target) {
  const PixelFormatInfo& pixel_format = *format.pixel_format;
  const uint16_t black = format.is_full_range ? 0 : 16;
  std::fill_n(target->border_values, 4, uint16_t{0});
  if (pixel_format.format == RG_FORMAT_RGB32)
    std::fill_n(target->border_values, 4, uint16_t{255});
  for (int i = 0; i < 3; ++i) {
    if (pixel_format.model == ColourModel::kRgb)
      target->border_values[pixel_format.order[i]] = 0;
    if (pixel_format.model == ColourModel::kYuv)
      target->border_values[i] = i == 0 ? black : 128;
  }
}

}  // namespace raygrid
