/// Controls of libcamera's cameras by their names: ExposureTime, AfMode.
#ifndef RAYGRID_LIBCAMERA_LIBCAMERA_CONTROLS_H
#define RAYGRID_LIBCAMERA_LIBCAMERA_CONTROLS_H

#include <libcamera/controls.h>

#include <string>

#include "frame_source.h"

namespace raygrid {

/// The list that camera.start() takes. A value is a number, or true or false,
/// or X,Y,WxH of a rectangle; AfMode also takes Manual, Auto and Continuous.
/// Throws CameraError (wrong usage) where the camera has no such control, or
/// the value is none of its type or out of its range.
libcamera::ControlList MakeControlList(
    const libcamera::ControlInfoMap& controls, const ControlValues& values);

/// "  --control ExposureTime=100 to 33333" and so on, a line each.
std::string DescribeControls(const libcamera::ControlInfoMap& controls);

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_LIBCAMERA_CONTROLS_H
