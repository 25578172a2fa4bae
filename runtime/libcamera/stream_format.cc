#include "stream_format.h"

#include <algorithm>
#include <cctype>
#include <cstring>

#include "camera_error.h"
#include "frames/pixel_formats.h"
#include "rg_blob.h"

namespace raygrid {
namespace {

// Chroma planes have half the rows; those of YUV420 also have half the stride.
PlaneLayout LayOutPlane(const rg_component& component, uint32_t width,
                        uint32_t height, uint32_t first_stride) {
  PlaneLayout layout;
  layout.row_bytes = rg_plane_row_bytes(&component, width);
  // Components of a Bayer plane share its rows.
  layout.rows = component.row_step == 1 ? height >> component.log2[1] : height;
  const bool is_half_stride =
      component.plane != 0 && component.num_channels == 1;
  layout.stride = is_half_stride ? first_stride / 2 : first_stride;
  return layout;
}

// Removes the spaces that pad a V4L2 code.
std::string AsItIs(const std::string& name) {
  return name.substr(0, name.find_last_not_of(' ') + 1);
}

// GStreamer writes GRAY16_LE in caps, and gray16-le elsewhere.
std::string ToLower(const std::string& name) {
  std::string result = AsItIs(name);
  for (char& letter : result)
    letter = letter == '_' ? '-' : static_cast<char>(std::tolower(letter));
  return result;
}

}  // namespace

const std::vector<PixelFormatInfo>& PixelFormats() {
  static const std::vector<PixelFormatInfo> formats = {
#include "pixel_format_names.inc"
  };
  return formats;
}

const PixelFormatInfo* FindPixelFormat(const std::string& name) {
  for (const PixelFormatInfo& format : PixelFormats())
    if (name == format.name) return &format;
  return nullptr;
}

std::string DescribeOtherName(const std::string& name) {
  for (const auto& simplify : {AsItIs, ToLower})
    for (const PixelFormatInfo& format : PixelFormats())
      for (const char* other : {format.v4l2, format.ffmpeg, format.gstreamer})
        if (other && simplify(other) == simplify(name) && name != format.name)
          return std::string("use ") + format.name;
  return "";
}

const PixelFormatInfo& RequirePixelFormat(const std::string& name) {
  const PixelFormatInfo* const format = FindPixelFormat(name);
  if (format) return *format;
  std::string remedy = DescribeOtherName(name);
  if (remedy.empty()) {
    remedy = "use one of";
    for (const PixelFormatInfo& known : PixelFormats())
      remedy +=
          std::string(&known == &PixelFormats()[0] ? " " : ", ") + known.name;
  }
  throw CameraError(CameraExit::kUsage,
                    "--format: " + name + " is not supported; " + remedy);
}

std::string RawVideoParseName(const PixelFormatInfo& format) {
  return format.gstreamer && format.model != ColourModel::kBayer
             ? ToLower(format.gstreamer)
             : "";
}

SampleChannel FindChannel(rg_format format, uint32_t index) {
  SampleChannel channel = {};
  for (uint32_t k = 0; rg_get_component(format, k, &channel.component); ++k) {
    if (index < channel.component.num_channels) break;
    index -= channel.component.num_channels;
  }
  channel.first_sample = channel.component.first_sample + index;
  return channel;
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
  rg_component component;
  for (uint32_t i = 0; rg_get_component(pixel_format.format, i, &component);
       ++i) {
    const uint32_t row_bytes = rg_plane_row_bytes(&component, width);
    if (row_bytes == 0 || (height & ((1u << component.log2[1]) - 1)) != 0)
      throw bad_size;
    if (component.plane == 0 && stride == 0) stride = row_bytes;
    result.planes[component.plane] =
        LayOutPlane(component, width, height, stride);
    result.num_planes = std::max(result.num_planes, component.plane + 1);
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
