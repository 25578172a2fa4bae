#ifndef RAYGRID_CAMERA_CONTROL_ARGUMENTS_H
#define RAYGRID_CAMERA_CONTROL_ARGUMENTS_H

#include <string>

#include "frame_source.h"

namespace raygrid {

/// The name and the value of --control NAME=VALUE. Throws CameraError (wrong
/// usage) where one of them is missing.
ControlValue ParseControl(const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CONTROL_ARGUMENTS_H
