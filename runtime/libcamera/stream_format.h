/// The format of a stream's frames: what they hold, and how they lie in memory.
#ifndef RAYGRID_LIBCAMERA_STREAM_FORMAT_H
#define RAYGRID_LIBCAMERA_STREAM_FORMAT_H

#include <string>
#include <vector>

#include "raygrid.h"

namespace raygrid {

enum class ColourModel : uint8_t { kGrey, kRgb, kYuv, kBayer };

/// A pixel format by libcamera's name.
struct PixelFormatInfo {
  const char* name;
  rg_format format;
  ColourModel model;
  uint8_t bits;  // of a sample
  /// Where colours are: bytes of red, green, blue, or Y, U, V, in a group of
  /// interleaved samples; the planes of YUV420, or which sample of NV12's
  /// second plane; of Bayer formats the pixel of the 2 x 2 that is red, the
  /// first green one, blue.
  uint8_t order[3];
  /// Its name in V4L2, in ffmpeg and as GStreamer's rawvideoparse has it; NULL
  /// where there is none.
  const char* v4l2;
  const char* ffmpeg = nullptr;
  const char* gstreamer = nullptr;
};

/// NULL for a format that the runtime does not undistort.
const PixelFormatInfo* FindPixelFormat(const std::string& name);

/// FindPixelFormat() of an option --format. Throws CameraError (wrong usage),
/// which says libcamera's name of a format that others name otherwise.
const PixelFormatInfo& RequirePixelFormat(const std::string& name);

/// "R8 is its name here" for a name of another program; else empty.
std::string DescribeOtherName(const std::string& name);

/// Names of all formats that the runtime undistorts.
std::vector<std::string> PixelFormatNames();

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
