/// The format of a stream's frames: channels and memory layout.
#ifndef RAYGRID_LIBCAMERA_STREAM_FORMAT_H
#define RAYGRID_LIBCAMERA_STREAM_FORMAT_H

#include <string>
#include <vector>

#include "kernels/samples.h"
#include "raygrid.h"

namespace raygrid {

enum class ColourModel : uint8_t { kGrey, kRgb, kYuv, kBayer };

/// A pixel format by libcamera's name, from formats/pixel_formats.toml.
/// libcamera uses DRM names, which refer to little-endian words: RGB888 is
/// blue, green, red in memory.
struct PixelFormatInfo {
  const char* name;
  rg_format format;
  ColourModel model;
  uint8_t bits;  // per sample
  /// Channel indices of red, the first green and blue, or of Y, U and V.
  uint8_t order[3];
  /// Names in V4L2, in V4L2 with separate memory for each plane, in ffmpeg and
  /// in GStreamer's caps; NULL if there is none.
  const char *v4l2, *v4l2_separate, *ffmpeg, *gstreamer;
};

/// A channel of a frame: channels are numbered over a format's components in
/// order, as in border_values of rg_target.
struct SampleChannel {
  rg_component component;
  uint32_t first_sample;
};

/// All formats that the runtime supports.
const std::vector<PixelFormatInfo>& PixelFormats();

/// Finds a format by libcamera's name; NULL if it is not supported.
const PixelFormatInfo* FindPixelFormat(const std::string& name);

/// FindPixelFormat() for an option --format. Throws CameraError (wrong usage),
/// which suggests libcamera's name if the format has another name elsewhere.
const PixelFormatInfo& RequirePixelFormat(const std::string& name);

/// Formats the hint "R8 is its name here" for another program's name, or "".
std::string DescribeOtherName(const std::string& name);

/// Returns the name for GStreamer's rawvideoparse; empty if there is none.
std::string RawVideoParseName(const PixelFormatInfo& format);

/// Returns a channel; index must be less than the number of channels.
SampleChannel FindChannel(rg_format format, uint32_t index);

struct PlaneLayout {
  uint32_t stride, row_bytes, rows;
  /// Bytes from the start of the first row to the end of the last one.
  uint32_t extent() const { return stride * (rows - 1) + row_bytes; }
};

struct StreamFormat {
  const PixelFormatInfo* pixel_format;
  uint16_t width, height;
  int num_planes;
  PlaneLayout planes[3];
  /// Whether Y is 0 for black and 255 for white; otherwise 16 and 235.
  bool is_full_range;

  uint32_t packed_size() const;  // bytes of a frame without row padding
};

/// Returns the layout of frames, with limited range as from cameras.
/// stride: bytes per row of the first plane; 0: rows without padding. Strides
/// of the other planes follow as in V4L2. Throws CameraError if the size is
/// invalid for the format, or the stride too small.
StreamFormat MakeStreamFormat(const PixelFormatInfo& pixel_format,
                              uint32_t width, uint32_t height, uint32_t stride);

/// Returns an image with the given planes.
rg_image MakeImage(const StreamFormat& format, const uint8_t* const planes[3]);

/// Sets border_values of rg_target to opaque black.
void SetBlackBorder(const StreamFormat& format, rg_target* target);

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_STREAM_FORMAT_H
