#ifndef RAYGRID_CAMERA_OBSERVATION_LINE_H
#define RAYGRID_CAMERA_OBSERVATION_LINE_H

#include <Eigen/Core>

namespace raygrid {

/// Line of sight in metres: the points origin + t direction, t > 0.
struct ObservationLine {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction;  ///< unit vector
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_OBSERVATION_LINE_H
