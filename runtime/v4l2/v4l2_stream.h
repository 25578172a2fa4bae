/// The format requested from a V4L2 device, and its memory layout.
#ifndef RAYGRID_V4L2_V4L2_STREAM_H
#define RAYGRID_V4L2_V4L2_STREAM_H

#include <linux/videodev2.h>

#include <array>
#include <string>

#include "camera_error.h"
#include "stream_format.h"
#include "v4l2_device.h"

namespace raygrid {

struct V4l2Stream {
  uint32_t buffer_type;  // V4L2_BUF_TYPE_VIDEO_CAPTURE, or multiplanar
  bool is_jpeg;          // frames are JPEGs, decoded to the format
  StreamFormat format;
  // Memory planes per frame: one, or one for each plane of the pixel format.
  uint32_t num_mem_planes;
  std::array<uint32_t, 3> mem_plane_sizes;
  struct Place {
    uint32_t mem_plane, offset;
  };
  std::array<Place, 3> places;  // location of each plane

  bool is_multiplanar() const {
    return buffer_type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
  }
};

/// Returns an error of a device, in one line.
CameraError V4l2Error(const V4l2Device& device, const std::string& what);

/// Returns an error for the errno of a failed call: "another process uses the
/// device", or words, the description of the errno, and the remedy.
CameraError V4l2Error(const V4l2Device& device, const std::string& words,
                      int error, const std::string& remedy);

/// Returns the type of the device's capture buffers. Throws CameraError if it
/// has none, or does not support streaming.
uint32_t FindBufferType(V4l2Device* device);

/// Sets the device's format: the named one, or for "" the first supported one
/// of this size, preferring uncompressed formats and the current one. JPEG
/// (name MJPEG) is the last choice, if takes_jpegs.
V4l2Stream ChooseStream(V4l2Device* device, const std::string& name,
                        unsigned width, unsigned height, bool takes_jpegs);

}  // namespace raygrid

#endif  // RAYGRID_V4L2_V4L2_STREAM_H
