#ifndef RAYGRID_HAND_EYE_HAND_EYE_INPUT_H
#define RAYGRID_HAND_EYE_HAND_EYE_INPUT_H

#include <map>
#include <string>
#include <vector>

#include "hand_eye/hand_eye_model.h"

namespace raygrid {

/// Combines poses of one target with the robot's poses, in the order of the
/// target's poses; images without a robot pose are omitted.
std::vector<HandEyeObservation> MakeHandEyeObservations(
    const std::vector<TargetPose>& targets,
    const std::map<std::string, Pose>& base_from_gripper);

}  // namespace raygrid

#endif  // RAYGRID_HAND_EYE_HAND_EYE_INPUT_H
