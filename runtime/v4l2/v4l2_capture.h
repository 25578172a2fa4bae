/// Capture settings of a V4L2 device, as far as its driver provides them.
#ifndef RAYGRID_V4L2_V4L2_CAPTURE_H
#define RAYGRID_V4L2_V4L2_CAPTURE_H

#include <linux/videodev2.h>

#include <optional>
#include <vector>

#include "frame_source.h"
#include "v4l2_device.h"

namespace raygrid {

/// Reads the crop, the zoom (the ratio of zoom_absolute to its minimum), flips,
/// and the exposure time if it is in effect. focus_absolute has no unit: its
/// steps are provided instead of lens positions. Gains have no unit either and
/// are not read.
class V4l2CaptureReader {
 public:
  /// Queries the device's controls. The device must outlive this object.
  explicit V4l2CaptureReader(V4l2Device* device);

  bool reports_crops() const { return has_crop_; }
  /// Sets the fields of a frame's info that the device currently provides.
  void Read(FrameInfo* info) const;

 private:
  struct Control {
    uint32_t id;
    long long minimum;
  };

  std::optional<SensorCrop> ReadCrop() const;
  bool HasControl(uint32_t id) const;
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
