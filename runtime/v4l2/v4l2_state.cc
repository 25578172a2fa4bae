#include "v4l2_state.h"

#include <cerrno>
#include <cstring>
#include <optional>
#include <string>

#include "v4l2_controls.h"

namespace raygrid {

/// A quantity with an automatic mode: the control of the mode, its manual
/// values, the best first, and alternative controls for the fixed quantity.
struct V4l2StateLock::Subject {
  std::string name;
  uint32_t mode;
  std::vector<int32_t> manual;
  std::vector<uint32_t> values;
};

namespace {

// Returns EIO if the device reports success, but changes the value.
int SetAndVerify(V4l2Device* device, uint32_t id, int32_t value) {
  const int status = SetV4l2Control(device, id, value);
  if (status != 0) return status;
  return GetV4l2Control(device, id).value_or(value) == value ? 0 : EIO;
}

std::optional<v4l2_query_ext_ctrl> FindFirst(V4l2Device* device,
                                             const std::vector<uint32_t>& ids) {
  for (const uint32_t id : ids)
    if (const auto control = QueryV4l2Control(device, id)) return control;
  return std::nullopt;
}

std::optional<int32_t> ReadInEffect(V4l2Device* device, uint32_t id) {
  const auto control = QueryV4l2Control(device, id);
  if (!control || !IsInEffect(*control)) return std::nullopt;
  return GetV4l2Control(device, id);
}

// "exposure 8.3 ms", "focus at 40 (0 to 250)"
std::string DescribeFixed(const std::string& name,
                          const v4l2_query_ext_ctrl& control, int32_t value) {
  if (control.id == V4L2_CID_EXPOSURE_ABSOLUTE)
    return DescribeExposure(double{kExposureUnit_us} * value);
  if (control.id == V4L2_CID_WHITE_BALANCE_TEMPERATURE)
    return name + " " + std::to_string(value) + " K";
  return name + " at " + std::to_string(value) + " (" +
         std::to_string(control.minimum) + " to " +
         std::to_string(control.maximum) + ")";
}

}  // namespace

// Returns 0, or the errno of the best value.
int V4l2StateLock::EndMode(const Subject& subject) {
  const std::optional<int32_t> before = GetV4l2Control(device_, subject.mode);
  int error = 0;
  for (const int32_t manual : subject.manual) {
    if (before == manual) return 0;
    const int status = SetAndVerify(device_, subject.mode, manual);
    if (status == 0) {
      if (before) disabled_modes_.push_back({subject.mode, *before});
      return 0;
    }
    if (error == 0) error = status;
  }
  return error;
}

std::optional<int32_t> V4l2StateLock::GetRequestedValue(uint32_t id) const {
  return id == V4L2_CID_FOCUS_ABSOLUTE ? focus_ : std::nullopt;
}

// Returns whether it is fixed.
bool V4l2StateLock::Fix(const Subject& subject, StateLock* lock) {
  const bool has_mode = QueryV4l2Control(device_, subject.mode).has_value();
  const auto control = FindFirst(device_, subject.values);
  if (!has_mode && !control) {
    lock->open.push_back(subject.name + ": the camera has no control for it");
    return false;
  }
  // Before the mode ends, a value is read only if it is in effect: drivers may
  // cache what they read.
  const std::optional<int32_t> before =
      control ? ReadInEffect(device_, control->id) : std::nullopt;
  const int error = has_mode ? EndMode(subject) : 0;
  if (error != 0) {
    lock->open.push_back(subject.name +
                         ": cannot disable the automatic mode (" +
                         std::strerror(error) + ")");
    return false;
  }
  std::optional<int32_t> value =
      control ? GetV4l2Control(device_, control->id) : std::nullopt;
  const std::optional<int32_t> wanted =
      control && GetRequestedValue(control->id) ? GetRequestedValue(control->id)
                                                : before;
  if (wanted && value != wanted &&
      SetV4l2Control(device_, control->id, *wanted) == 0) {
    if (wanted != before && before)
      disabled_modes_.push_back({control->id, *before});
    value = GetV4l2Control(device_, control->id);
  }
  lock->locked.push_back(value ? DescribeFixed(subject.name, *control, *value)
                               : subject.name +
                                     " at a value the camera does not report");
  return true;
}

void V4l2StateLock::FocusAt(std::optional<int> focus_steps) {
  const std::lock_guard<std::mutex> guard(mutex_);
  focus_ = focus_steps;
}

StateLock V4l2StateLock::Lock() {
  static const Subject kFocus = {
      "focus", V4L2_CID_FOCUS_AUTO, {0}, {V4L2_CID_FOCUS_ABSOLUTE}};
  static const Subject kExposure = {
      "exposure",
      V4L2_CID_EXPOSURE_AUTO,
      {V4L2_EXPOSURE_MANUAL, V4L2_EXPOSURE_SHUTTER_PRIORITY},
      {V4L2_CID_EXPOSURE_ABSOLUTE, V4L2_CID_EXPOSURE}};
  static const Subject kGain = {
      "gain", V4L2_CID_AUTOGAIN, {0}, {V4L2_CID_ANALOGUE_GAIN, V4L2_CID_GAIN}};
  static const Subject kWhiteBalance = {"white balance",
                                        V4L2_CID_AUTO_WHITE_BALANCE,
                                        {0},
                                        {V4L2_CID_WHITE_BALANCE_TEMPERATURE}};
  const std::lock_guard<std::mutex> guard(mutex_);
  StateLock lock;
  Fix(kFocus, &lock);
  const bool is_exposure_fixed = Fix(kExposure, &lock);
  // USB cameras have one mode for both.
  if (!is_exposure_fixed && QueryV4l2Control(device_, V4L2_CID_EXPOSURE_AUTO) &&
      !QueryV4l2Control(device_, V4L2_CID_AUTOGAIN))
    lock.open.push_back("gain: controlled by auto exposure");
  else
    Fix(kGain, &lock);
  Fix(kWhiteBalance, &lock);
  return lock;
}

void V4l2StateLock::Unlock() {
  const std::lock_guard<std::mutex> guard(mutex_);
  for (; !disabled_modes_.empty(); disabled_modes_.pop_back())
    SetV4l2Control(device_, disabled_modes_.back().id,
                   disabled_modes_.back().value);
}

}  // namespace raygrid
