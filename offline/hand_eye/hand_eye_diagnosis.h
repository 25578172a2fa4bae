#ifndef RAYGRID_HAND_EYE_HAND_EYE_DIAGNOSIS_H
#define RAYGRID_HAND_EYE_HAND_EYE_DIAGNOSIS_H

#include <string>
#include <vector>

#include "hand_eye/linear_hand_eye.h"

namespace raygrid {

/// Formats an axis, whose sign is arbitrary: "[0.00, 1.00, 0.00]".
std::string FormatAxis(const Eigen::Vector3d& axis);

/// Throws Error(kInitializationFailed) if the mount does not rotate, or about
/// one axis only, with what remains undetermined and which motion is missing.
void RequireRotations(const RotationSpread& rotations, Mounting mounting);

/// Throws InputError if robot poses are in other units than the target's poses:
/// compares the lengths of the paths from pose to pose.
void RequireSameUnit(const std::vector<HandEyeObservation>& observations,
                     Mounting mounting);

/// Throws Error(kInitializationFailed) if a robust start does not fit, or if
/// inverted robot poses fit much better. Says so if poses would fit with
/// another order of the quaternion, or if the rows are shifted by one.
void RequireFit(const std::vector<HandEyeObservation>& observations,
                Mounting mounting, const RobustStart& start);

}  // namespace raygrid

#endif  // RAYGRID_HAND_EYE_HAND_EYE_DIAGNOSIS_H
