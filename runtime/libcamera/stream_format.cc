#include "stream_format.h"

#include <algorithm>
#include <cctype>
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
    {"R8", RG_FORMAT_GREY8, kGrey, 8, {}, "GREY", "gray", "gray8"},
    {"R10", RG_FORMAT_GREY16, kGrey, 10, {}, "Y10 ", "gray10le"},
    {"R12", RG_FORMAT_GREY16, kGrey, 12, {}, "Y12 ", "gray12le"},
    {"R14", RG_FORMAT_GREY16, kGrey, 14, {}, "Y14 ", "gray14le"},
    {"R16", RG_FORMAT_GREY16, kGrey, 16, {}, "Y16 ", "gray16le", "gray16-le"},
    {"R10_CSI2P", RG_FORMAT_GREY10P, kGrey, 10, {}, "Y10P"},
    {"R12_CSI2P", RG_FORMAT_GREY12P, kGrey, 12, {}, "Y12P"},
    {"RGB888", RG_FORMAT_RGB24, kRgb, 8, {2, 1, 0}, "BGR3", "bgr24", "bgr"},
    {"BGR888", RG_FORMAT_RGB24, kRgb, 8, {0, 1, 2}, "RGB3", "rgb24", "rgb"},
    {"XRGB8888", RG_FORMAT_RGB32, kRgb, 8, {2, 1, 0}, "XR24", "bgr0", "bgrx"},
    {"ARGB8888", RG_FORMAT_RGB32, kRgb, 8, {2, 1, 0}, "AR24", "bgra", "bgra"},
    {"XBGR8888", RG_FORMAT_RGB32, kRgb, 8, {0, 1, 2}, "XB24", "rgb0", "rgbx"},
    {"ABGR8888", RG_FORMAT_RGB32, kRgb, 8, {0, 1, 2}, "AB24", "rgba", "rgba"},
    {"RGBX8888", RG_FORMAT_RGB32, kRgb, 8, {3, 2, 1}, "RX24", "0bgr", "xbgr"},
    {"RGBA8888", RG_FORMAT_RGB32, kRgb, 8, {3, 2, 1}, "RA24", "abgr", "abgr"},
    {"BGRX8888", RG_FORMAT_RGB32, kRgb, 8, {1, 2, 3}, "BX24", "0rgb", "xrgb"},
    {"BGRA8888", RG_FORMAT_RGB32, kRgb, 8, {1, 2, 3}, "BA24", "argb", "argb"},
    {"XVUY8888", RG_FORMAT_RGB32, kYuv, 8, {0, 1, 2}, "YUVX"},
    {"AVUY8888", RG_FORMAT_RGB32, kYuv, 8, {0, 1, 2}, "YUVA"},
    {"RGB565",
     RG_FORMAT_RGB565,
     kRgb,
     8,
     {0, 1, 2},
     "RGBP",
     "rgb565le",
     "rgb16"},
    {"YUYV", RG_FORMAT_YUYV, kYuv, 8, {0, 1, 3}, "YUYV", "yuyv422", "yuy2"},
    {"YVYU", RG_FORMAT_YUYV, kYuv, 8, {0, 3, 1}, "YVYU", "yvyu422", "yvyu"},
    {"UYVY", RG_FORMAT_UYVY, kYuv, 8, {1, 0, 2}, "UYVY", "uyvy422", "uyvy"},
    {"VYUY", RG_FORMAT_UYVY, kYuv, 8, {1, 2, 0}, "VYUY", nullptr, "vyuy"},
    {"NV12", RG_FORMAT_NV12, kYuv, 8, {0, 0, 1}, "NV12", "nv12", "nv12"},
    {"NV21", RG_FORMAT_NV12, kYuv, 8, {0, 1, 0}, "NV21", "nv21", "nv21"},
    {"YUV420", RG_FORMAT_YUV420, kYuv, 8, {0, 1, 2}, "YU12", "yuv420p", "i420"},
    {"YVU420", RG_FORMAT_YUV420, kYuv, 8, {0, 2, 1}, "YV12", nullptr, "yv12"},
    {"SRGGB8", RG_FORMAT_BAYER8, kBayer, 8, {0, 1, 3}, "RGGB", "bayer_rggb8"},
    {"SGRBG8", RG_FORMAT_BAYER8, kBayer, 8, {1, 0, 2}, "GRBG", "bayer_grbg8"},
    {"SGBRG8", RG_FORMAT_BAYER8, kBayer, 8, {2, 0, 1}, "GBRG", "bayer_gbrg8"},
    {"SBGGR8", RG_FORMAT_BAYER8, kBayer, 8, {3, 1, 0}, "BA81", "bayer_bggr8"},
    {"SRGGB10", RG_FORMAT_BAYER16, kBayer, 10, {0, 1, 3}, "RG10"},
    {"SGRBG10", RG_FORMAT_BAYER16, kBayer, 10, {1, 0, 2}, "BA10"},
    {"SGBRG10", RG_FORMAT_BAYER16, kBayer, 10, {2, 0, 1}, "GB10"},
    {"SBGGR10", RG_FORMAT_BAYER16, kBayer, 10, {3, 1, 0}, "BG10"},
    {"SRGGB12", RG_FORMAT_BAYER16, kBayer, 12, {0, 1, 3}, "RG12"},
    {"SGRBG12", RG_FORMAT_BAYER16, kBayer, 12, {1, 0, 2}, "BA12"},
    {"SGBRG12", RG_FORMAT_BAYER16, kBayer, 12, {2, 0, 1}, "GB12"},
    {"SBGGR12", RG_FORMAT_BAYER16, kBayer, 12, {3, 1, 0}, "BG12"},
    {"SRGGB14", RG_FORMAT_BAYER16, kBayer, 14, {0, 1, 3}, "RG14"},
    {"SGRBG14", RG_FORMAT_BAYER16, kBayer, 14, {1, 0, 2}, "GR14"},
    {"SGBRG14", RG_FORMAT_BAYER16, kBayer, 14, {2, 0, 1}, "GB14"},
    {"SBGGR14", RG_FORMAT_BAYER16, kBayer, 14, {3, 1, 0}, "BG14"},
    {"SRGGB16", RG_FORMAT_BAYER16, kBayer, 16, {0, 1, 3}, "RG16"},
    {"SGRBG16", RG_FORMAT_BAYER16, kBayer, 16, {1, 0, 2}, "GR16"},
    {"SGBRG16", RG_FORMAT_BAYER16, kBayer, 16, {2, 0, 1}, "GB16"},
    {"SBGGR16", RG_FORMAT_BAYER16, kBayer, 16, {3, 1, 0}, "BYR2"},
    {"SRGGB10_CSI2P", RG_FORMAT_BAYER10P, kBayer, 10, {0, 1, 3}, "pRAA"},
    {"SGRBG10_CSI2P", RG_FORMAT_BAYER10P, kBayer, 10, {1, 0, 2}, "pgAA"},
    {"SGBRG10_CSI2P", RG_FORMAT_BAYER10P, kBayer, 10, {2, 0, 1}, "pGAA"},
    {"SBGGR10_CSI2P", RG_FORMAT_BAYER10P, kBayer, 10, {3, 1, 0}, "pBAA"},
    {"SRGGB12_CSI2P", RG_FORMAT_BAYER12P, kBayer, 12, {0, 1, 3}, "pRCC"},
    {"SGRBG12_CSI2P", RG_FORMAT_BAYER12P, kBayer, 12, {1, 0, 2}, "pgCC"},
    {"SGBRG12_CSI2P", RG_FORMAT_BAYER12P, kBayer, 12, {2, 0, 1}, "pGCC"},
    {"SBGGR12_CSI2P", RG_FORMAT_BAYER12P, kBayer, 12, {3, 1, 0}, "pBCC"},
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

// Without the spaces that fill a code of V4L2.
std::string AsItIs(const std::string& name) {
  return name.substr(0, name.find_last_not_of(' ') + 1);
}

// GStreamer writes GRAY16_LE in caps, and gray16-le elsewhere.
std::string InSmallLetters(const std::string& name) {
  std::string result = AsItIs(name);
  for (char& letter : result)
    letter = letter == '_' ? '-' : static_cast<char>(std::tolower(letter));
  return result;
}

}  // namespace

const PixelFormatInfo* FindPixelFormat(const std::string& name) {
  for (const PixelFormatInfo& format : kFormats)
    if (name == format.name) return &format;
  return nullptr;
}

std::string DescribeOtherName(const std::string& name) {
  for (const auto& simplify : {AsItIs, InSmallLetters})
    for (const PixelFormatInfo& format : kFormats)
      for (const char* other : {format.v4l2, format.ffmpeg, format.gstreamer})
        if (other && simplify(other) == simplify(name) && name != format.name)
          return std::string(format.name) + " is the name used here";
  return "";
}

const PixelFormatInfo& RequirePixelFormat(const std::string& name) {
  const PixelFormatInfo* const format = FindPixelFormat(name);
  if (format) return *format;
  std::string remedy = DescribeOtherName(name);
  if (remedy.empty()) {
    remedy = "use one of";
    for (const PixelFormatInfo& known : kFormats)
      remedy += std::string(&known == kFormats ? " " : ", ") + known.name;
  }
  throw CameraError(CameraExit::kUsage,
                    "--format: " + name + " is not supported; " + remedy);
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
      text + ": invalid size for this format; use another --size");
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
                        text + ": stride of " + std::to_string(stride) +
                            " bytes is out of range; use another --format");
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
