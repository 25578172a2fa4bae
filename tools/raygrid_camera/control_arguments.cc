#include "control_arguments.h"

#include "camera_error.h"

namespace raygrid {

ControlValue ParseControl(const std::string& text) {
  const size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    throw CameraError(
        CameraExit::kUsage,
        "--control: " + text +
            ": expected NAME=VALUE, such as exposure_time_absolute=100");
  return {text.substr(0, equals), text.substr(equals + 1)};
}

}  // namespace raygrid
