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

// The offset and scale of one axis, in calibrated pixels.
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
                                      uint16_t height, const Flips& flips) {
  rg_mode mode = {};
  mode.width = width;
  mode.height = height;
  mode.flip_x = flips.x;
  mode.flip_y = flips.y;
  uint16_t calibrated_width, calibrated_height;
  rg_calibrated_size(&camera, &calibrated_width, &calibrated_height);
  if (!FindAxis(calibrated.x, calibrated.width, calibrated_width, crop.x,
                crop.width, width, &mode.offset_x_q16, &mode.scale_x_q16) ||
      !FindAxis(calibrated.y, calibrated.height, calibrated_height, crop.y,
                crop.height, height, &mode.offset_y_q16, &mode.scale_y_q16))
    return std::nullopt;
  return mode;
}

uint32_t FindTable(const rg_camera& camera, const StreamFormat& format,
                   const std::optional<SensorCrop>& calibrated,
                   const std::optional<SensorCrop>& shown, const Flips& flips) {
  std::optional<rg_mode> mode;
  if (calibrated && shown) {
    mode = FindSensorMode(camera, *calibrated, *shown, format.width,
                          format.height, flips);
    if (!mode) return RG_NO_TABLE;
  }
  uint32_t table;
  rg_match(&camera, mode ? &*mode : nullptr, format.width, format.height,
           nullptr, &table);
  return table;
}

std::string DescribeTableFault(const rg_camera& camera, uint32_t table) {
  rg_camera other = camera;
  const std::string name = "remap table " + std::to_string(table);
  const rg_status status = rg_select_remap(&other, table);
  if (status != RG_ERR_NO_REMAP)
    return name + ": " + rg_status_text(status) +
           "; pack or copy the blob again";
  uint32_t number = 0;
  while (rg_select_remap(&other, number) != RG_ERR_NO_REMAP) ++number;
  if (number == 0) return "has no remap table; pack the blob with --remap";
  return "has no " + name + ", only 0" +
         (number > 1 ? " to " + std::to_string(number - 1) : "") +
         "; use one of these, or add one with raygrid pack --remap";
}

bool HasTablesOfModes(const rg_camera& camera) {
  rg_camera other = camera;
  rg_mode mode;
  for (uint32_t k = 0; rg_select_remap(&other, k) == RG_OK; ++k)
    if (rg_remap_mode(&other, &mode) == RG_OK &&
        rg_match(&other, &mode, mode.width, mode.height, nullptr, nullptr) ==
            RG_MATCH_MODE)
      return true;
  return false;
}

StreamGuard::StreamGuard(const rg_camera& camera, const StreamFormat& format,
                         Use use, const std::string& serial,
                         const std::optional<SensorCrop>& calibrated,
                         CaptureGuard* capture)
    : camera_(camera),
      format_(format),
      use_(use),
      serial_(serial),
      capture_(capture),
      is_recorded_(calibrated),
      calibrated_(calibrated || !capture ? calibrated : capture->crop()) {}

const char* StreamGuard::serial() const {
  return serial_.empty() ? nullptr : serial_.c_str();
}

bool StreamGuard::HasSerial() const {
  uint16_t width, height;
  rg_calibrated_size(&camera_, &width, &height);
  return rg_match(&camera_, nullptr, width, height, serial(), nullptr) ==
         RG_MATCH_EXACT;
}

bool StreamGuard::MatchesTableSize() const {
  uint16_t width, height;
  rg_frame_size(&camera_, &width, &height);
  return format_.width == width && format_.height == height;
}

std::string StreamGuard::DescribeFault() const {
  if (!HasSerial())
    return "belongs to a camera with a serial number other than " + serial_ +
           "; use the blob of this camera";
  uint16_t width, height;
  rg_frame_size(&camera_, &width, &height);
  std::string text = "supports frames of " + Size(width, height);
  if (calibrated_ && last_)
    text += " with crop " + Text(*calibrated_) + ", but these are " +
            Size(format_.width, format_.height) + " with crop " + Text(*last_);
  else if (last_ && !(last_ == first_))
    text +=
        " with crop " + Text(*first_) + ", but these have crop " + Text(*last_);
  else
    text += ", but the camera delivers " + Size(format_.width, format_.height);
  return text +
         "; select that mode (see --list), or add a table for this one with "
         "raygrid pack --mode NAME:crop=X,Y,W,H,size=" +
         Size(format_.width, format_.height);
}

// Whether the table in use accepts the last frame's sensor mode or, if only
// points are needed, its positions can be converted.
bool StreamGuard::IsSupported() const {
  const bool is_known = calibrated_ && last_;
  if ((is_known && !mode_) || !HasSerial()) return false;
  uint32_t table;
  const rg_match_result match =
      rg_match(&camera_, mode_ ? &*mode_ : nullptr, format_.width,
               format_.height, serial(), &table);
  if (use_ == Use::kPositions) return match != RG_MATCH_NONE;
  if (!MatchesTableSize()) return false;
  if (!is_known) return !last_ || last_ == first_;
  rg_mode in_use;
  uint32_t first_of_mode;
  if (rg_remap_mode(&camera_, &in_use) != RG_OK) return false;
  rg_match(&camera_, &in_use, in_use.width, in_use.height, nullptr,
           &first_of_mode);
  return table != RG_NO_TABLE && table == first_of_mode;
}

// Whether the table accepts the last frame's size, although its sensor crop
// differs from the one that the blob records: the CaptureGuard then decides.
bool StreamGuard::IsTolerated() const {
  return capture_ && capture_->crop() && !is_recorded_ && last_ &&
         use_ == Use::kFrames && HasSerial() && MatchesTableSize();
}

bool StreamGuard::IsShownAsInUse(const FrameInfo& info) {
  if (is_known_ && info.crop == last_ && info.orientation == last_orientation_)
    return is_supported_;
  is_known_ = false;
  last_ = info.crop;
  last_orientation_ = info.orientation;
  if (!first_) first_ = info.crop;
  // If the calibrated crop is unknown, frames of its size are accepted.
  uint16_t width, height;
  rg_calibrated_size(&camera_, &width, &height);
  if (!calibrated_ && format_.width == width && format_.height == height)
    calibrated_ = info.crop;
  mode_.reset();
  if (calibrated_ && last_)
    mode_ = FindSensorMode(camera_, *calibrated_, *last_, format_.width,
                           format_.height,
                           capture_ ? capture_->GetFlips(info) : Flips());
  is_supported_ = IsSupported();
  if (!is_supported_ && !IsTolerated())
    throw CameraError(CameraExit::kBlob, "blob: " + DescribeFault());
  is_known_ = true;
  return is_supported_;
}

bool StreamGuard::Check(const FrameInfo& info, Clock::time_point arrived) {
  const bool is_shown_as_in_use = IsShownAsInUse(info);
  if (!capture_) return true;
  rg_mode in_use;
  const bool has_mode = rg_remap_mode(&camera_, &in_use) == RG_OK;
  return capture_->Check(info, has_mode ? &in_use : nullptr, is_shown_as_in_use,
                         arrived);
}

}  // namespace raygrid
