/// One undistorted frame and a line of text, which --check asks for.
#ifndef RAYGRID_CAMERA_CAMERA_CHECK_H
#define RAYGRID_CAMERA_CAMERA_CHECK_H

#include <string>

#include "camera_arguments.h"
#include "frame_source.h"
#include "undistorter.h"

namespace raygrid {

/// The arguments of a session that undistorts as these ask, ends after a frame,
/// and neither writes nor serves.
CameraArguments MakeCheckArguments(CameraArguments arguments);

/// The blob, the frames and their source in a line. Throws CameraError where no
/// frame was undistorted.
std::string DescribeCheck(const CameraArguments& arguments,
                          const FrameSource& source,
                          const Undistorter& undistorter);

/// Throws the CameraError of a check that ended before a frame came.
[[noreturn]] void FailCheck();

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_CHECK_H
