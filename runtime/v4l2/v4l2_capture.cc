#include "v4l2_capture.h"

#include <algorithm>

#include "capture_guard.h"
#include "v4l2_controls.h"

namespace raygrid {
namespace {

constexpr uint32_t kReadControls[] = {
    V4L2_CID_ZOOM_ABSOLUTE,  V4L2_CID_HFLIP,
    V4L2_CID_VFLIP,          V4L2_CID_ROTATE,
    V4L2_CID_FOCUS_ABSOLUTE, V4L2_CID_EXPOSURE_ABSOLUTE};

bool IsReadControl(const v4l2_query_ext_ctrl& control) {
  if ((control.flags & (V4L2_CTRL_FLAG_DISABLED | V4L2_CTRL_FLAG_WRITE_ONLY)) !=
      0)
    return false;
  for (const uint32_t id : kReadControls)
    if (control.id == id) return true;
  return false;
}

// The orientation of frames rotated clockwise by degrees; 0 if invalid.
int OrientationFromRotation(int32_t degrees) {
  switch (degrees) {
    case 0:
      return 1;
    case 90:
      return 8;
    case 180:
      return 3;
    case 270:
      return 6;
    default:
      return 0;
  }
}

}  // namespace

V4l2CaptureReader::V4l2CaptureReader(V4l2Device* device) : device_(device) {
  v4l2_query_ext_ctrl control = {};
  for (;;) {
    control.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
    if (IoctlWithRetry(device, VIDIOC_QUERY_EXT_CTRL, &control) != 0) break;
    if (IsReadControl(control))
      controls_.push_back({control.id, control.minimum});
  }
  has_crop_ = ReadCrop().has_value();
}

std::optional<SensorCrop> V4l2CaptureReader::ReadCrop() const {
  v4l2_selection crop = {};
  // Also for multiplanar devices.
  crop.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  crop.target = V4L2_SEL_TGT_CROP;
  if (IoctlWithRetry(device_, VIDIOC_G_SELECTION, &crop) != 0 ||
      crop.r.width == 0 || crop.r.height == 0)
    return std::nullopt;
  return SensorCrop{crop.r.left, crop.r.top, crop.r.width, crop.r.height};
}

bool V4l2CaptureReader::HasControl(uint32_t id) const {
  return std::any_of(controls_.begin(), controls_.end(),
                     [id](const Control& known) { return known.id == id; });
}

std::optional<int32_t> V4l2CaptureReader::ReadValue(uint32_t id) const {
  if (!HasControl(id)) return std::nullopt;
  return GetV4l2Control(device_, id);
}

// zoom_absolute is a focal length in a driver-specific unit. If its minimum is
// 0, there is no ratio: the zoom is then known only at the minimum.
std::optional<double> V4l2CaptureReader::ReadZoom() const {
  const std::optional<int32_t> value = ReadValue(V4L2_CID_ZOOM_ABSOLUTE);
  if (!value) return std::nullopt;
  for (const Control& known : controls_) {
    if (known.id != V4L2_CID_ZOOM_ABSOLUTE) continue;
    if (*value == known.minimum) return 1;
    if (known.minimum > 0)
      return static_cast<double>(*value) / static_cast<double>(known.minimum);
  }
  return std::nullopt;
}

std::optional<int> V4l2CaptureReader::ReadOrientation() const {
  const std::optional<int32_t> flip_x = ReadValue(V4L2_CID_HFLIP),
                               flip_y = ReadValue(V4L2_CID_VFLIP),
                               degrees = ReadValue(V4L2_CID_ROTATE);
  if (!flip_x && !flip_y && !degrees) return std::nullopt;
  const int orientation = Mirrored(OrientationFromRotation(degrees.value_or(0)),
                                   flip_x.value_or(0), flip_y.value_or(0));
  return orientation != 0 ? std::optional(orientation) : std::nullopt;
}

std::optional<float> V4l2CaptureReader::ReadExposure() const {
  if (!HasControl(V4L2_CID_EXPOSURE_ABSOLUTE)) return std::nullopt;
  const auto control = QueryV4l2Control(device_, V4L2_CID_EXPOSURE_ABSOLUTE);
  if (!control || !IsInEffect(*control)) return std::nullopt;
  const std::optional<int32_t> value = ReadValue(V4L2_CID_EXPOSURE_ABSOLUTE);
  if (!value || *value <= 0) return std::nullopt;
  return static_cast<float>(*value) * kExposureUnit_us;
}

void V4l2CaptureReader::Read(FrameInfo* info) const {
  if (has_crop_) info->crop = ReadCrop();
  info->zoom = ReadZoom();
  info->orientation = ReadOrientation();
  info->focus_steps = ReadValue(V4L2_CID_FOCUS_ABSOLUTE);
  info->exposure_us = ReadExposure();
}

}  // namespace raygrid
