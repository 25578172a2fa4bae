#ifndef RAYGRID_INITIALIZATION_LOCALIZATION_H
#define RAYGRID_INITIALIZATION_LOCALIZATION_H

#include <optional>
#include <vector>

#include "camera/camera_model.h"
#include "camera/pose.h"

namespace raygrid {

/// A known point and the pixel that shows it.
struct PointOnPixel {
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;
};

/// camera_from_pattern for a camera that is known: SQPnP on the pixels' rays
/// (Terzakis and Lourakis, 2020), then the least robust reprojection error
/// (Huber, 1 px), linearised at each pixel; once more without gross outliers,
/// if there are any. Pixels outside the calibrated area are left out; nothing
/// if fewer than four remain or no pose is found.
std::optional<Pose> Localize(const CameraModel& camera,
                             const std::vector<PointOnPixel>& matches);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_LOCALIZATION_H
