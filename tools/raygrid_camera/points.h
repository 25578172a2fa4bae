#ifndef RAYGRID_CAMERA_POINTS_H
#define RAYGRID_CAMERA_POINTS_H

#include <cstdio>
#include <functional>
#include <optional>
#include <string>

#include "raygrid.h"
#include "stack_follower.h"

namespace raygrid {

/// Lines x,y (pixels of the mode) to lines x,y,u,v (pixels of the undistorted
/// image; empty where there is none), each as soon as it is there. A third
/// number of a line is where in the blob's range its frame was taken, and those
/// behind it, too. A first line that is no numbers is a header. Throws
/// CameraError.
///
/// stack  of the camera
void UndistortPoints(const rg_camera& camera,
                     const std::optional<rg_mode>& mode,
                     const std::string& path, std::FILE* output,
                     const std::function<bool()>& is_stopped,
                     StackFollower* stack);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_POINTS_H
