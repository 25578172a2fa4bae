/// libcamera controls by name, such as ExposureTime or AfMode.
#ifndef RAYGRID_LIBCAMERA_LIBCAMERA_CONTROLS_H
#define RAYGRID_LIBCAMERA_LIBCAMERA_CONTROLS_H

#include <libcamera/controls.h>

#include <string>

#include "frame_source.h"

namespace raygrid {

/// Returns the list for camera.start(). A value is a number, true or false, or
/// a rectangle X,Y,WxH; AfMode also accepts Manual, Auto and Continuous. Throws
/// CameraError (wrong usage) for an unknown control, or a value of another type
/// or out of range.
libcamera::ControlList MakeControlList(
    const libcamera::ControlInfoMap& controls, const ControlValues& values);

/// Lists controls, one per line: "  --control ExposureTime=100 to 33333".
std::string DescribeControls(const libcamera::ControlInfoMap& controls);

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_LIBCAMERA_CONTROLS_H
