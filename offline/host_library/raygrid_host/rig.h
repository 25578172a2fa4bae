/// @file
/// Cameras that are fixed to each other.
#ifndef RAYGRID_HOST_RIG_H
#define RAYGRID_HOST_RIG_H

#include <raygrid_host/camera.h>

namespace raygrid {

/// A camera of a rig.
template <typename Scalar>
struct RigCamera {
  /// Name in rig.yaml.
  std::string name;
  /// The camera.
  Camera<Scalar> camera;
  /// point_camera = camera_from_rig * point_rig.
  PoseTransform camera_from_rig;
};

/// Reads a rig.yaml and the camera.yaml files that it refers to.
/// @param path the file
/// @param error if not null, receives one line that says what is wrong
/// @return the cameras in the order of the file; none if a file is unreadable
/// or malformed
template <typename Scalar>
RAYGRID_HOST_API std::vector<RigCamera<Scalar>> LoadRig(
    const std::string& path, std::string* error = nullptr);

}  // namespace raygrid

#endif  // RAYGRID_HOST_RIG_H
