#include "libcamera_state.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

namespace raygrid {
namespace {

using libcamera::ControlInfo;
using StateValue = libcamera::ControlValue;

// Limits that are missing, or of another type, are ignored.
template <typename Number>
Number Within(const ControlInfo& info, Number number) {
  const libcamera::ControlType type = StateValue(number).type();
  if (info.min().type() == type && !info.min().isArray())
    number = std::max(number, info.min().get<Number>());
  if (info.max().type() == type && !info.max().isArray())
    number = std::min(number, info.max().get<Number>());
  return number;
}

// Modes are numbers, or true and false.
bool TakesMode(const ControlInfo& info, const StateValue& mode) {
  const auto& values = info.values();
  if (!values.empty())
    return std::find(values.begin(), values.end(), mode) != values.end();
  if (mode.type() == libcamera::ControlTypeInteger32)
    return Within(info, mode.get<int32_t>()) == mode.get<int32_t>();
  return info.min().type() != mode.type() || info.min() == mode ||
         info.max() == mode;
}

class LockMaker {
 public:
  LockMaker(const libcamera::ControlInfoMap& controls,
            const libcamera::ControlList& given)
      : controls_(controls), given_(given) {
    lock_.lock_controls = libcamera::ControlList(controls);
    lock_.unlock_controls = libcamera::ControlList(controls);
  }

  // Returns whether the camera has the mode. `values`: controls that the user
  // may have set instead, in which case nothing is automatic.
  bool EndMode(const std::string& name, const StateValue& manual,
               const StateValue& automatic,
               const std::vector<std::string>& values) {
    const auto found = Find(name);
    if (found == controls_.end() || !TakesMode(found->second, manual))
      return false;
    const unsigned id = found->first->id();
    lock_.lock_controls.set(id, manual);
    StateValue before = automatic;
    if (given_.contains(id))
      before = given_.get(id);
    else if (std::any_of(
                 values.begin(), values.end(),
                 [this](const std::string& value) { return IsGiven(value); }))
      before = manual;
    else if (found->second.def().type() == manual.type())
      before = found->second.def();
    if (before != manual) lock_.unlock_controls.set(id, before);
    return true;
  }

  // Returns whether the camera has the control, and the value is known.
  bool Fix(const std::string& name, const std::optional<float>& value) {
    const auto found = Find(name);
    if (found == controls_.end() || !value) return false;
    const unsigned id = found->first->id();
    if (found->first->type() == libcamera::ControlTypeInteger32)
      lock_.lock_controls.set(
          id, StateValue(Within(found->second,
                                static_cast<int32_t>(std::lround(*value)))));
    else if (found->first->type() == libcamera::ControlTypeFloat)
      lock_.lock_controls.set(id, StateValue(Within(found->second, *value)));
    else
      return false;
    if (given_.contains(id)) lock_.unlock_controls.set(id, given_.get(id));
    return true;
  }

  void AddControl(const std::string& subject, bool is_fixed,
                  const std::string& value) {
    if (!is_fixed)
      lock_.lock_state.open.push_back(subject +
                                      ": libcamera has no control for it");
    else if (value.empty())
      lock_.lock_state.locked.push_back(
          subject + " at a value the camera does not report");
    else
      lock_.lock_state.locked.push_back(value);
  }

  const LibcameraLock& lock() const { return lock_; }

 private:
  // By name: versions differ in the controls that they support.
  libcamera::ControlInfoMap::const_iterator Find(
      const std::string& name) const {
    return std::find_if(
        controls_.begin(), controls_.end(),
        [&name](const auto& control) { return control.first->name() == name; });
  }

  bool IsGiven(const std::string& name) const {
    const auto found = Find(name);
    return found != controls_.end() && given_.contains(found->first->id());
  }

  const libcamera::ControlInfoMap& controls_;
  const libcamera::ControlList& given_;
  LibcameraLock lock_;
};

std::string DescribeNumber(const char* format,
                           const std::optional<float>& number) {
  if (!number) return "";
  char text[64];
  std::snprintf(text, sizeof(text), format, double{*number});
  return text;
}

}  // namespace

LibcameraLock MakeLibcameraLock(const libcamera::ControlInfoMap& controls,
                                const libcamera::ControlList& given,
                                const FrameInfo& now) {
  const StateValue kManualFocus(int32_t{0}), kManual(int32_t{1}),
      kAutomatic(int32_t{0}), kOff(false), kOn(true);
  LockMaker maker(controls, given);

  // A lens without an automatic mode does not move.
  const bool has_focus =
      maker.EndMode("AfMode", kManualFocus, kManualFocus, {"LensPosition"});
  const bool has_lens = maker.Fix("LensPosition", now.lens_position);
  maker.AddControl("focus", has_focus || has_lens,
                   DescribeNumber("focus at %.2f dioptres", now.lens_position));

  // Since libcamera 0.5, exposure time and gain have separate modes; AeEnable
  // applies to both.
  bool has_exposure =
      maker.EndMode("ExposureTimeMode", kManual, kAutomatic, {"ExposureTime"});
  bool has_gain =
      maker.EndMode("AnalogueGainMode", kManual, kAutomatic, {"AnalogueGain"});
  if ((!has_exposure || !has_gain) &&
      maker.EndMode("AeEnable", kOff, kOn, {"ExposureTime", "AnalogueGain"}))
    has_exposure = has_gain = true;
  has_exposure |= maker.Fix("ExposureTime", now.exposure_us);
  has_gain |= maker.Fix("AnalogueGain", now.analogue_gain);
  maker.AddControl(
      "exposure", has_exposure,
      now.exposure_us ? DescribeExposure(double{*now.exposure_us}) : "");
  maker.AddControl("gain", has_gain,
                   DescribeNumber("gain %.1f", now.analogue_gain));

  const bool has_white = maker.EndMode("AwbEnable", kOff, kOn,
                                       {"ColourGains", "ColourTemperature"});
  maker.AddControl("white balance", has_white, "white balance");
  return maker.lock();
}

}  // namespace raygrid
