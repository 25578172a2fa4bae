#ifndef RAYGRID_HAND_EYE_HAND_EYE_FILE_H
#define RAYGRID_HAND_EYE_HAND_EYE_FILE_H

#include <string>
#include <vector>

#include "hand_eye/hand_eye_calibration.h"

namespace raygrid {

/// A transformation of the result with the covariance of the update of
/// UpdatedPose().
struct NamedTransform {
  std::string name;  ///< such as "camera_from_gripper"
  Pose pose;
  PoseCovariance covariance = PoseCovariance::Zero();

  /// Standard deviations: RMS angle (rad) and RMS length (m).
  double RotationStdDev() const;
  double TranslationStdDev() const;
};

/// Returns camera_from_mount, its inverse, and anchor_from_target.
std::vector<NamedTransform> ListTransforms(const HandEyeFit& fit,
                                           Mounting mounting);

/// Formats hand_eye.yaml. camera: name of the camera; may be empty.
std::string FormatHandEye(const std::string& camera, Mounting mounting,
                          const HandEyeResult& result);

/// Formats hand_eye_residuals.csv, one row per image.
std::string FormatHandEyeResiduals(
    const std::vector<HandEyeObservation>& observations,
    const HandEyeResult& result);

}  // namespace raygrid

#endif  // RAYGRID_HAND_EYE_HAND_EYE_FILE_H
