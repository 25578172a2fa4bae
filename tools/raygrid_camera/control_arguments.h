#ifndef RAYGRID_CAMERA_CONTROL_ARGUMENTS_H
#define RAYGRID_CAMERA_CONTROL_ARGUMENTS_H

#include <string>

#include "frame_source.h"

namespace raygrid {

/// Parses --control NAME=VALUE. Throws CameraError (wrong usage) if the name or
/// the value is missing.
ControlValue ParseControl(const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CONTROL_ARGUMENTS_H
