#include "libcamera_controls.h"

#include <libcamera/control_ids.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <vector>

#include "camera_error.h"

namespace raygrid {
namespace {

using libcamera::ControlId;
using libcamera::ControlInfo;
using libcamera::ControlInfoMap;
using Value = libcamera::ControlValue;

// Controls by name, with their ranges; sorted by name.
std::map<std::string, std::pair<const ControlId*, ControlInfo>> ListControls(
    const ControlInfoMap& controls) {
  std::map<std::string, std::pair<const ControlId*, ControlInfo>> listed;
  for (const auto& [id, info] : controls)
    listed.insert({id->name(), {id, info}});
  return listed;
}

bool ParseNumber(const std::string& text, double* number) {
  char* end;
  errno = 0;
  *number = std::strtod(text.c_str(), &end);
  return end != text.c_str() && *end == 0 && errno == 0 &&
         std::isfinite(*number);
}

template <typename Integer>
bool ParseInteger(const std::string& text, Value* value) {
  char* end;
  errno = 0;
  const long long number = std::strtoll(text.c_str(), &end, 10);
  if (end == text.c_str() || *end != 0 || errno != 0 ||
      number < std::numeric_limits<Integer>::min() ||
      number > std::numeric_limits<Integer>::max())
    return false;
  *value = Value(static_cast<Integer>(number));
  return true;
}

bool ParseBool(const std::string& text, Value* value) {
  const bool is_true = text == "true" || text == "1";
  if (!is_true && text != "false" && text != "0") return false;
  *value = Value(is_true);
  return true;
}

bool ParseRectangle(const std::string& text, Value* value) {
  int x, y;
  unsigned width, height;
  char more;
  if (std::sscanf(text.c_str(), "%9d,%9d,%9ux%9u%c", &x, &y, &width, &height,
                  &more) != 4)
    return false;
  *value = Value(libcamera::Rectangle(x, y, width, height));
  return true;
}

// Parses a value of the control's type.
bool ParseValue(const ControlId& id, const std::string& text, Value* value) {
  static const std::vector<std::string> kAfModes = {"Manual", "Auto",
                                                    "Continuous"};
  if (id.id() == libcamera::controls::AfMode.id()) {
    const auto mode = std::find(kAfModes.begin(), kAfModes.end(), text);
    if (mode != kAfModes.end()) {
      *value = Value(static_cast<int32_t>(mode - kAfModes.begin()));
      return true;
    }
  }
  switch (id.type()) {
    case libcamera::ControlTypeBool:
      return ParseBool(text, value);
    case libcamera::ControlTypeByte:
      return ParseInteger<uint8_t>(text, value);
    case libcamera::ControlTypeInteger32:
      return ParseInteger<int32_t>(text, value);
    case libcamera::ControlTypeInteger64:
      return ParseInteger<int64_t>(text, value);
    case libcamera::ControlTypeFloat: {
      double number;
      if (!ParseNumber(text, &number)) return false;
      *value = Value(static_cast<float>(number));
      return true;
    }
    case libcamera::ControlTypeRectangle:
      return ParseRectangle(text, value);
    default:
      return false;
  }
}

// Limits that are missing, or of another type, are ignored.
template <typename Number>
bool IsBetween(const ControlInfo& info, const Value& value) {
  if (info.min().type() != value.type() || info.max().type() != value.type() ||
      info.min().isArray() || info.max().isArray())
    return true;
  const Number number = value.get<Number>();
  return number >= info.min().get<Number>() &&
         number <= info.max().get<Number>();
}

bool IsInRange(const ControlInfo& info, const Value& value) {
  switch (value.type()) {
    case libcamera::ControlTypeByte:
      return IsBetween<uint8_t>(info, value);
    case libcamera::ControlTypeInteger32:
      return IsBetween<int32_t>(info, value);
    case libcamera::ControlTypeInteger64:
      return IsBetween<int64_t>(info, value);
    case libcamera::ControlTypeFloat:
      return IsBetween<float>(info, value);
    default:
      return true;
  }
}

std::string FormatRange(const ControlInfo& info) {
  if (info.min().isNone()) return "";
  return info.min().toString() + " to " + info.max().toString();
}

CameraError UsageError(const libcamera::ControlInfoMap& controls,
                       const ControlValue& control) {
  const auto listed = ListControls(controls);
  const auto found = listed.find(control.first);
  if (found == listed.end())
    return CameraError(CameraExit::kUsage,
                       "--control: the camera has no control " + control.first +
                           "; see --list");
  const std::string range = FormatRange(found->second.second);
  return CameraError(
      CameraExit::kUsage,
      "--control: " + control.first + " does not accept " + control.second +
          (range.empty() ? "; see --help" : "; valid range: " + range));
}

}  // namespace

libcamera::ControlList MakeControlList(const ControlInfoMap& controls,
                                       const ControlValues& values) {
  libcamera::ControlList list(controls);
  const auto listed = ListControls(controls);
  for (const ControlValue& control : values) {
    const auto found = listed.find(control.first);
    Value value;
    if (found == listed.end() ||
        !ParseValue(*found->second.first, control.second, &value) ||
        !IsInRange(found->second.second, value))
      throw UsageError(controls, control);
    list.set(found->second.first->id(), value);
  }
  return list;
}

std::string DescribeControls(const ControlInfoMap& controls) {
  std::string text;
  for (const auto& [name, control] : ListControls(controls)) {
    const std::string range = FormatRange(control.second);
    text +=
        "  --control " + name + "=" + (range.empty() ? "..." : range) + "\n";
  }
  return text;
}

}  // namespace raygrid
