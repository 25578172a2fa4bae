#ifndef RAYGRID_CAMERA_NEAREST_ROTATION_H
#define RAYGRID_CAMERA_NEAREST_ROTATION_H

#include <Eigen/Geometry>

#include "camera/camera_model.h"

namespace raygrid {

/// Computes the rotation target_from_camera that best aligns the directions of
/// two cameras' pixels (Wahba 1965), over a lattice in an area.
Eigen::Quaterniond ComputeNearestRotation(const CameraModel& target,
                                          const CameraModel& camera,
                                          const Area& area);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_NEAREST_ROTATION_H
