#ifndef RAYGRID_EVALUATION_NONCENTRALITY_H
#define RAYGRID_EVALUATION_NONCENTRALITY_H

#include <Eigen/Core>

#include "camera/camera_model.h"

namespace raygrid {

/// Distances of a camera's observation lines from the point closest to all of
/// them; zero for a central camera.
struct Noncentrality {
  Eigen::Vector3d nearest_point = Eigen::Vector3d::Zero();
  double rms_m = 0, max_m = 0;
};

/// Computes the spread of the lines over the area.
Noncentrality ComputeNoncentrality(const CameraModel& camera);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_NONCENTRALITY_H
