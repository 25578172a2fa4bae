/// Controls of libcamera's cameras by name: ExposureTime, AfMode.
#ifndef RAYGRID_LIBCAMERA_LIBCAMERA_CONTROLS_H
#define RAYGRID_LIBCAMERA_LIBCAMERA_CONTROLS_H

#include <libcamera/controls.h>

#include <string>

#include "frame_source.h"

namespace raygrid {

/// Makes the list for camera.start(). A value is a number, true or false, or a
/// rectangle X,Y,WxH; AfMode also accepts Manual, Auto and Continuous. Throws
/// CameraError (wrong usage) for an unknown control, or a value of another type
/// or outside the range.
libcamera::ControlList MakeControlList(
    const libcamera::ControlInfoMap& controls, const ControlValues& values);

/// "  --control ExposureTime=100 to 33333" and so on, one per line.
std::string DescribeControls(const libcamera::ControlInfoMap& controls);

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_LIBCAMERA_CONTROLS_H
