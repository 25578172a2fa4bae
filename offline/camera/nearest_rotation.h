#ifndef RAYGRID_CAMERA_NEAREST_ROTATION_H
#define RAYGRID_CAMERA_NEAREST_ROTATION_H

#include <Eigen/Geometry>

#include "camera/camera_model.h"

namespace raygrid {

/// The rotation that brings the directions of a camera's pixels nearest to
/// those of another one (Wahba 1965), over a lattice in an area.
Eigen::Quaterniond ComputeNearestRotation(const CameraModel& target,
                                          const CameraModel& camera,
                                          const Area& area);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_NEAREST_ROTATION_H
