#ifndef RAYGRID_INITIALIZATION_LOCALIZATION_H
#define RAYGRID_INITIALIZATION_LOCALIZATION_H

#include <optional>
#include <vector>

#include "camera/camera_model.h"
#include "camera/pose.h"

namespace raygrid {

/// A known point and its observation.
struct PointPixelMatch {
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;
};

/// Estimates camera_from_pattern with fixed intrinsics (resection): SQPnP on
/// rays (Terzakis and Lourakis, 2020), followed by minimization of the robust
/// reprojection error (Huber, 1 px), linearized at each pixel; repeated without
/// gross outliers. Ignores pixels outside the calibrated area. Returns nullopt
/// if fewer than four matches remain or no pose is found.
std::optional<Pose> Localize(const CameraModel& camera,
                             const std::vector<PointPixelMatch>& matches);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_LOCALIZATION_H
