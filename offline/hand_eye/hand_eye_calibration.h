#ifndef RAYGRID_HAND_EYE_HAND_EYE_CALIBRATION_H
#define RAYGRID_HAND_EYE_HAND_EYE_CALIBRATION_H

#include <optional>
#include <string>
#include <vector>

#include "hand_eye/hand_eye_refinement.h"
#include "hand_eye/linear_hand_eye.h"
#include "hand_eye/next_robot_pose.h"

namespace raygrid {

/// Minimum number of poses.
constexpr int kMinHandEyePoses = 3;

/// A difference of the observed and the predicted pose of the target.
struct HandEyeError {
  double rotation_rad = 0;
  double translation_m = 0;  ///< of the origin of the target
  double rms_px = 0;         ///< of the target's features
};

/// The result for one observation.
struct HandEyePoseResult {
  HandEyeError residual;
  std::optional<HandEyeError> held_out;  ///< predicted from the other poses
  bool is_used = true;
  std::string reason;  ///< why it is not used
};

/// Root mean squares over poses.
struct HandEyeErrorMetrics {
  HandEyeError rms;
  int count = 0;
};

struct HandEyeResult {
  HandEyeFit fit;
  std::vector<HandEyePoseResult> poses;  ///< as the observations
  HandEyeErrorMetrics residual, held_out;
  RotationSpread rotations;  ///< of the mount, in the poses that are used
  /// Eigenvalues of the information about both transformations, ascending,
  /// with translations in units of the target's distance (1 / rad^2).
  Vector12d information = Vector12d::Zero();
  std::optional<ScaleError> scale;
  std::optional<SuggestedPose> suggestion;
  /// Mean squared error per degree of freedom of the poses that are used: 1 if
  /// the noise is as stated.
  double variance_ratio = 1;
  std::vector<std::string> warnings;

  int NumUsed() const;
};

/// Estimates camera_from_mount and anchor_from_target: a robust linear start,
/// removal of poses that do not fit, RefineHandEye(), cross-validation and
/// observability. Throws Error(kInsufficientData) for too few poses, and
/// Error(kInitializationFailed) if rotations are missing, or if no solution
/// fits; says so if it would fit with inverted robot poses, another order of
/// the quaternion, or rows that are shifted.
HandEyeResult CalibrateHandEye(
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    const StatedRobotNoise& stated);

}  // namespace raygrid

#endif  // RAYGRID_HAND_EYE_HAND_EYE_CALIBRATION_H
