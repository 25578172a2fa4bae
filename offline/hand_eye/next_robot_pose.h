#ifndef RAYGRID_HAND_EYE_NEXT_ROBOT_POSE_H
#define RAYGRID_HAND_EYE_NEXT_ROBOT_POSE_H

#include <optional>
#include <string>
#include <vector>

#include "hand_eye/hand_eye_refinement.h"

namespace raygrid {

/// A pose that would improve the result most.
struct SuggestedPose {
  Pose base_from_gripper;
  std::string near_image;  ///< the pose it is reached from
  char axis = 'x';  ///< axis of the target, about which the camera orbits
  double angle_rad = 0;
  /// Standard deviations of camera_from_mount (RMS angle, RMS length), without
  /// and with the additional pose.
  double rotation_stddev_rad = 0, translation_stddev_m = 0;
  double new_rotation_stddev_rad = 0, new_translation_stddev_m = 0;
};

/// Searches poses in which the camera is moved around the target, from the
/// poses of a subset, with the target in view and not tilted further than in
/// the subset or 45 degrees. nullopt if none improves the result.
std::optional<SuggestedPose> SuggestRobotPose(
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    const std::vector<int>& subset, const HandEyeFit& fit);

}  // namespace raygrid

#endif  // RAYGRID_HAND_EYE_NEXT_ROBOT_POSE_H
