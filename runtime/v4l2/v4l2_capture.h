/// How a V4L2 device takes its frames, as far as its driver tells.
#ifndef RAYGRID_V4L2_V4L2_CAPTURE_H
#define RAYGRID_V4L2_V4L2_CAPTURE_H

#include <linux/videodev2.h>

#include <optional>
#include <vector>

#include "frame_source.h"
#include "v4l2_device.h"

namespace raygrid {

/// Asks for the crop, for zoom_absolute, whose ratio to its minimum is the
/// magnification, for flips, and for the exposure time where it is in effect.
/// focus_absolute has no unit: lens positions are not told, but its steps are.
/// Gains have no unit either.
class V4l2CaptureReader {
 public:
  /// Finds what the device has. It must outlive this.
  explicit V4l2CaptureReader(V4l2Device* device);

  bool tells_crops() const { return has_crop_; }
  /// Sets what of a frame's info the device tells now.
  void Read(FrameInfo* info) const;

 private:
  struct Control {
    uint32_t id;
    long long minimum;
  };

  std::optional<SensorCrop> ReadCrop() const;
  bool Knows(uint32_t id) const;
  std::optional<int32_t> ReadValue(uint32_t id) const;
  std::optional<double> ReadZoom() const;
  std::optional<int> ReadOrientation() const;
  std::optional<float> ReadExposure() const;

  V4l2Device* const device_;
  std::vector<Control> controls_;
  bool has_crop_ = false;
};

}  // namespace raygrid

#endif  // RAYGRID_V4L2_V4L2_CAPTURE_H
