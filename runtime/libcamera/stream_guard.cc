#include "stream_guard.h"

#include <cmath>

#include "camera_error.h"

namespace raygrid {
namespace {

constexpr double kOne_q16 = 65536;

std::string Size(unsigned width, unsigned height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

std::string Text(const SensorCrop& crop) {
  return std::to_string(crop.x) + "," + std::to_string(crop.y) + "," +
         Size(crop.width, crop.height);
}

// Offset and scale of one axis, in calibrated pixels.
bool FindAxis(int calibrated_start, unsigned calibrated_span,
              uint16_t calibrated_size, int start, unsigned span, uint16_t size,
              int32_t* offset_q16, uint32_t* scale_q16) {
  if (calibrated_span == 0 || span == 0 || size == 0) return false;
  const double per_sensor_pixel = double{1} * calibrated_size / calibrated_span;
  const double offset =
      (double{1} * start - calibrated_start) * per_sensor_pixel * kOne_q16;
  const double scale = per_sensor_pixel * span / size * kOne_q16;
  if (std::abs(offset) >= INT32_MAX || scale >= UINT32_MAX) return false;
  *offset_q16 = static_cast<int32_t>(std::lround(offset));
  *scale_q16 = static_cast<uint32_t>(std::lround(scale));
  return true;
}

}  // namespace

std::optional<rg_mode> FindSensorMode(const rg_camera& camera,
                                      const SensorCrop& calibrated,
                                      const SensorCrop& crop, uint16_t width,
                                      uint16_t height) {
  rg_mode mode = {};
  mode.width = width;
  mode.height = height;
  uint16_t frame_width, frame_height;
  rg_frame_size(&camera, &frame_width, &frame_height);
  if (!FindAxis(calibrated.x, calibrated.width, frame_width, crop.x, crop.width,
                width, &mode.offset_x_q16, &mode.scale_x_q16) ||
      !FindAxis(calibrated.y, calibrated.height, frame_height, crop.y,
                crop.height, height, &mode.offset_y_q16, &mode.scale_y_q16))
    return std::nullopt;
  return mode;
}

StreamGuard::StreamGuard(const rg_camera& camera, const StreamFormat& format,
                         Use use, const std::string& serial,
                         const std::optional<SensorCrop>& calibrated)
    : camera_(camera),
      format_(format),
      use_(use),
      serial_(serial),
      calibrated_(calibrated) {}

const char* StreamGuard::serial() const {
  return serial_.empty() ? nullptr : serial_.c_str();
}

std::string StreamGuard::Explain() const {
  uint16_t width, height;
  rg_frame_size(&camera_, &width, &height);
  if (rg_match(&camera_, nullptr, width, height, serial()) != RG_MATCH_EXACT)
    return "is for a camera of another serial number than " + serial_ +
           "; take the blob of this camera";
  std::string text = "serves frames of " + Size(width, height);
  if (calibrated_ && last_)
    text += " that show the part " + Text(*calibrated_) +
            " of the sensor, but these are " +
            Size(format_.width, format_.height) + " and show " + Text(*last_);
  else
    text += ", but the camera's are " + Size(format_.width, format_.height);
  return text +
         "; choose that mode (--list shows the camera's), or calibrate in this "
         "one";
}

void StreamGuard::Check(const FrameInfo& info) {
  if (is_good_ && info.crop == last_) return;
  is_good_ = false;
  last_ = info.crop;
  // Without a word on the calibration, frames of its size are taken for it.
  uint16_t width, height;
  rg_frame_size(&camera_, &width, &height);
  if (!calibrated_ && format_.width == width && format_.height == height)
    calibrated_ = info.crop;
  mode_.reset();
  const bool is_known = calibrated_ && last_;
  if (is_known)
    mode_ = FindSensorMode(camera_, *calibrated_, *last_, format_.width,
                           format_.height);
  const rg_match_result match =
      is_known && !mode_ ? RG_MATCH_NONE
                         : rg_match(&camera_, mode_ ? &*mode_ : nullptr,
                                    format_.width, format_.height, serial());
  is_good_ = match == RG_MATCH_EXACT ||
             (match == RG_MATCH_DERIVABLE && use_ == Use::kPositions);
  if (!is_good_) throw CameraError(CameraExit::kBlob, "blob: " + Explain());
}

}  // namespace raygrid
