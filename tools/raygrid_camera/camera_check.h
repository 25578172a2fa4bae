/// The option --check: one undistorted frame and a line of text.
#ifndef RAYGRID_CAMERA_CAMERA_CHECK_H
#define RAYGRID_CAMERA_CAMERA_CHECK_H

#include <string>

#include "camera_arguments.h"
#include "frame_source.h"
#include "undistorter.h"

namespace raygrid {

/// Returns the arguments of a session that undistorts equally, but ends after
/// one frame and has no output or server.
CameraArguments MakeCheckArguments(CameraArguments arguments);

/// Describes the blob, the frames and their source in a line. Throws
/// CameraError if no frame was undistorted.
std::string DescribeCheck(const CameraArguments& arguments,
                          const FrameSource& source,
                          const Undistorter& undistorter);

/// Throws the CameraError of a check that ended before the first frame.
[[noreturn]] void FailCheck();

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_CHECK_H
