/// The format of a stream's frames: what they hold, and how they lie in memory.
#ifndef RAYGRID_LIBCAMERA_STREAM_FORMAT_H
#define RAYGRID_LIBCAMERA_STREAM_FORMAT_H

#include <string>
#include <vector>

#include "kernels/samples.h"
#include "raygrid.h"

namespace raygrid {

enum class ColourModel : uint8_t { kGrey, kRgb, kYuv, kBayer };

/// A pixel format by libcamera's name, as formats/pixel_formats.toml has it.
/// DRM's names, which libcamera has, state the order in a little-endian word:
/// RGB888 is blue, green, red in memory.
struct PixelFormatInfo {
  const char* name;
  rg_format format;
  ColourModel model;
  uint8_t bits;  // of a sample
  /// Channels of red, the first green, and blue, or of Y, U and V.
  uint8_t order[3];
  /// Its name in V4L2, there also with a memory of its own for each plane, in
  /// ffmpeg and in GStreamer's caps; NULL where there is none.
  const char *v4l2, *v4l2_separate, *ffmpeg, *gstreamer;
};

/// A channel of a frame: those of a format's lattices in turn, as for
/// border_values of rg_target.
struct SampleChannel {
  rg_lattice lattice;
  uint32_t first_sample;
};

/// All formats that the runtime undistorts.
const std::vector<PixelFormatInfo>& PixelFormats();

/// By libcamera's name; NULL where it is none of them.
const PixelFormatInfo* FindPixelFormat(const std::string& name);

/// FindPixelFormat() of an option --format. Throws CameraError (wrong usage),
/// which says libcamera's name of a format that others name otherwise.
const PixelFormatInfo& RequirePixelFormat(const std::string& name);

/// "R8 is its name here" for a name of another program; else empty.
std::string DescribeOtherName(const std::string& name);

/// The name of GStreamer's rawvideoparse; empty where there is none.
std::string RawVideoParseName(const PixelFormatInfo& format);

/// The format has more channels than index.
SampleChannel FindChannel(rg_format format, uint32_t index);

struct PlaneLayout {
  uint32_t stride, row_bytes, rows;
  /// Bytes from the first one to the end of the last row.
  uint32_t extent() const { return stride * (rows - 1) + row_bytes; }
};

struct StreamFormat {
  const PixelFormatInfo* pixel_format;
  uint16_t width, height;
  int num_planes;
  PlaneLayout planes[3];
  /// Y of YUV is 0 in black and 255 in white; else 16 and 235.
  bool is_full_range;

  uint32_t packed_size() const;  // bytes of a frame whose rows have no gaps
};

/// The range is that of cameras: not the full one.
///
/// stride   of the first plane; 0: rows without gaps. The other planes' strides
///          follow from it as in V4L2.
/// Throws CameraError for a size that the format cannot have, or a stride that
/// is too small.
StreamFormat MakeStreamFormat(const PixelFormatInfo& pixel_format,
                              uint32_t width, uint32_t height, uint32_t stride);

/// An image over a frame's planes.
rg_image MakeImage(const StreamFormat& format, const uint8_t* const planes[3]);

/// Values of black, or of full opacity, for rg_target.
void SetBlackBorder(const StreamFormat& format, rg_target* target);

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_STREAM_FORMAT_H
