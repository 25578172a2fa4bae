#ifndef RAYGRID_CAMERA_POINTS_H
#define RAYGRID_CAMERA_POINTS_H

#include <cstdio>
#include <functional>
#include <optional>
#include <string>

#include "operating_point_follower.h"
#include "raygrid.h"

namespace raygrid {

/// Reads lines x,y (pixels of the mode) and writes lines x,y,u,v (pixels of the
/// undistorted image; empty if not visible), each immediately. A third number
/// is the operating point of the point's frame, which also applies to the
/// following lines. A first line without numbers is a header. Throws
/// CameraError.
///
/// stack  of the camera
void UndistortPoints(const rg_camera& camera,
                     const std::optional<rg_mode>& mode,
                     const std::string& path, std::FILE* output,
                     const std::function<bool()>& is_stopped,
                     OperatingPointFollower* stack);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_POINTS_H
