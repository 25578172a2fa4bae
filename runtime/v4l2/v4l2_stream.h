/// The frames that a V4L2 device is asked for, and how it lays them out.
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
  uint32_t buffer_type;  // V4L2_BUF_TYPE_VIDEO_CAPTURE, or with planes apart
  bool is_jpeg;          // frames are JPEGs, which become the format
  StreamFormat format;
  uint32_t num_memories;  // of a frame: one, or one for each plane
  std::array<uint32_t, 3> memory_sizes;
  struct Place {
    uint32_t memory, offset;
  };
  std::array<Place, 3> places;  // of the format's planes

  bool has_planes_apart() const {
    return buffer_type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
  }
};

/// An error of the device, in one line.
CameraError V4l2Error(const V4l2Device& device, const std::string& what);

/// For an errno of a call that fails: another process has the device, or the
/// words, what the errno means, and the remedy.
CameraError V4l2Error(const V4l2Device& device, const std::string& words,
                      int error, const std::string& remedy);

/// The type of the device's buffers of frames. Throws CameraError where it
/// gives none, or they cannot be streamed.
uint32_t FindBufferType(V4l2Device* device);

/// Sets the device's format: the one of that name, or for "" the first that the
/// runtime knows and that has the size, its own one before others. JPEGs are
/// the last choice, where they are taken; their name is MJPEG.
V4l2Stream ChooseStream(V4l2Device* device, const std::string& name,
                        unsigned width, unsigned height, bool takes_jpegs);

}  // namespace raygrid

#endif  // RAYGRID_V4L2_V4L2_STREAM_H
