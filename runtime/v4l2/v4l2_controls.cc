#include "v4l2_controls.h"

#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <vector>

#include "v4l2_stream.h"

namespace raygrid {
namespace {

// "Exposure Time, Absolute" is exposure_time_absolute.
std::string GetName(const v4l2_query_ext_ctrl& control) {
  std::string name;
  bool is_between = false;
  for (size_t i = 0; i < sizeof(control.name) && control.name[i] != 0; ++i) {
    const unsigned char letter = static_cast<unsigned char>(control.name[i]);
    if (std::isalnum(letter)) {
      if (is_between && !name.empty()) name += '_';
      name += static_cast<char>(std::tolower(letter));
    }
    is_between = !std::isalnum(letter);
  }
  return name;
}

bool IsMenu(const v4l2_query_ext_ctrl& control) {
  return control.type == V4L2_CTRL_TYPE_MENU ||
         control.type == V4L2_CTRL_TYPE_INTEGER_MENU;
}

bool HasNumber(const v4l2_query_ext_ctrl& control) {
  return control.type == V4L2_CTRL_TYPE_INTEGER ||
         control.type == V4L2_CTRL_TYPE_INTEGER64 ||
         control.type == V4L2_CTRL_TYPE_BOOLEAN ||
         control.type == V4L2_CTRL_TYPE_BITMASK || IsMenu(control);
}

bool CanBeSet(const v4l2_query_ext_ctrl& control) {
  return (control.flags &
          (V4L2_CTRL_FLAG_DISABLED | V4L2_CTRL_FLAG_READ_ONLY)) == 0 &&
         (HasNumber(control) || control.type == V4L2_CTRL_TYPE_BUTTON);
}

std::vector<v4l2_query_ext_ctrl> ListControls(V4l2Device* device) {
  std::vector<v4l2_query_ext_ctrl> controls;
  v4l2_query_ext_ctrl control = {};
  for (;;) {
    control.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
    if (IoctlWithRetry(device, VIDIOC_QUERY_EXT_CTRL, &control) != 0)
      return controls;
    if (CanBeSet(control)) controls.push_back(control);
  }
}

struct MenuItem {
  long long value;
  std::string text;
};

std::vector<MenuItem> ListItems(V4l2Device* device,
                                const v4l2_query_ext_ctrl& control) {
  std::vector<MenuItem> items;
  for (long long i = control.minimum; i <= control.maximum; ++i) {
    v4l2_querymenu item = {};
    item.id = control.id;
    item.index = static_cast<uint32_t>(i);
    if (IoctlWithRetry(device, VIDIOC_QUERYMENU, &item) != 0) continue;
    items.push_back(
        {i, control.type == V4L2_CTRL_TYPE_MENU
                ? std::string(reinterpret_cast<const char*>(item.name))
                : std::to_string(item.value)});
  }
  return items;
}

// "-64 to 64", "1 Manual Mode, 3 Aperture Priority Mode"
std::string Range(V4l2Device* device, const v4l2_query_ext_ctrl& control) {
  if (control.type == V4L2_CTRL_TYPE_BUTTON) return "1 to trigger it";
  std::string text;
  if (IsMenu(control)) {
    for (const MenuItem& item : ListItems(device, control))
      text += (text.empty() ? "" : ", ") + std::to_string(item.value) + " " +
              item.text;
    return text;
  }
  text = std::to_string(control.minimum) + " to " +
         std::to_string(control.maximum);
  if (control.step > 1) text += " in steps of " + std::to_string(control.step);
  return text;
}

std::optional<long long> ParseWhole(const std::string& text) {
  char* end;
  errno = 0;
  const long long value = std::strtoll(text.c_str(), &end, 0);
  if (end == text.c_str() || *end != 0 || errno != 0) return std::nullopt;
  return value;
}

// Returns the number for a value; nullopt if the control does not accept it.
std::optional<long long> FindValue(V4l2Device* device,
                                   const v4l2_query_ext_ctrl& control,
                                   const std::string& text) {
  const std::optional<long long> value = ParseWhole(text);
  if (control.type == V4L2_CTRL_TYPE_BUTTON)
    return value == 1 ? value : std::nullopt;
  if (IsMenu(control)) {
    for (const MenuItem& item : ListItems(device, control))
      if (value == item.value || (!value && text == item.text))
        return item.value;
    return std::nullopt;
  }
  if (!value || *value < control.minimum || *value > control.maximum)
    return std::nullopt;
  const unsigned long long above =
      static_cast<unsigned long long>(*value) -
      static_cast<unsigned long long>(control.minimum);
  if (control.step > 1 && above % control.step != 0) return std::nullopt;
  return value;
}

int Set(V4l2Device* device, const v4l2_query_ext_ctrl& control,
        long long* value) {
  const bool is_long = control.type == V4L2_CTRL_TYPE_INTEGER64;
  v4l2_ext_control setting = {};
  setting.id = control.id;
  if (is_long)
    setting.value64 = *value;
  else
    setting.value = static_cast<int32_t>(*value);
  v4l2_ext_controls settings = {};
  settings.count = 1;
  settings.controls = &setting;
  const int status = IoctlWithRetry(device, VIDIOC_S_EXT_CTRLS, &settings);
  *value = is_long ? setting.value64 : setting.value;
  return status;
}

v4l2_query_ext_ctrl FindControl(V4l2Device* device, const std::string& name) {
  for (const v4l2_query_ext_ctrl& control : ListControls(device))
    if (GetName(control) == name) return control;
  throw V4l2Error(*device, "has no settable control " + name + "; see --list");
}

void SetControl(V4l2Device* device, const std::string& name,
                const std::string& text) {
  const v4l2_query_ext_ctrl control = FindControl(device, name);
  if (control.flags & V4L2_CTRL_FLAG_INACTIVE)
    throw V4l2Error(*device, "control " + name +
                                 " is inactive; first set the control it "
                                 "depends on, such as auto_exposure");
  const std::optional<long long> wanted = FindValue(device, control, text);
  if (!wanted)
    throw V4l2Error(*device, "control " + name + " cannot be set to " + text +
                                 "; valid range: " + Range(device, control));
  long long value = *wanted;
  const int status = Set(device, control, &value);
  if (status != 0)
    throw V4l2Error(*device, "control " + name + " cannot be set to " + text,
                    status, "set it before other controls, or omit it");
  if (control.type != V4L2_CTRL_TYPE_BUTTON && value != *wanted)
    throw V4l2Error(*device, "control " + name + " was set to " +
                                 std::to_string(value) + " instead of " + text +
                                 "; use a value the camera supports");
}

}  // namespace

void SetV4l2Controls(V4l2Device* device, const ControlValues& controls) {
  for (const auto& [name, value] : controls) SetControl(device, name, value);
}

std::optional<v4l2_query_ext_ctrl> QueryV4l2Control(V4l2Device* device,
                                                    uint32_t id) {
  v4l2_query_ext_ctrl control = {};
  control.id = id;
  if (IoctlWithRetry(device, VIDIOC_QUERY_EXT_CTRL, &control) != 0 ||
      (control.flags & V4L2_CTRL_FLAG_DISABLED) != 0)
    return std::nullopt;
  return control;
}

std::optional<int32_t> GetV4l2Control(V4l2Device* device, uint32_t id) {
  v4l2_ext_control value = {};
  value.id = id;
  v4l2_ext_controls values = {};
  values.which = V4L2_CTRL_WHICH_CUR_VAL;
  values.count = 1;
  values.controls = &value;
  if (IoctlWithRetry(device, VIDIOC_G_EXT_CTRLS, &values) != 0)
    return std::nullopt;
  // The kernel's structure is packed: references are not allowed.
  return int32_t{value.value};
}

int SetV4l2Control(V4l2Device* device, uint32_t id, int32_t value) {
  v4l2_ext_control setting = {};
  setting.id = id;
  setting.value = value;
  v4l2_ext_controls settings = {};
  settings.which = V4L2_CTRL_WHICH_CUR_VAL;
  settings.count = 1;
  settings.controls = &setting;
  return IoctlWithRetry(device, VIDIOC_S_EXT_CTRLS, &settings);
}

std::string DescribeV4l2Controls(V4l2Device* device) {
  std::string text;
  for (const v4l2_query_ext_ctrl& control : ListControls(device))
    text +=
        "  --control " + GetName(control) + "=" + Range(device, control) + "\n";
  return text;
}

}  // namespace raygrid
