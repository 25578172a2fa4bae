#ifndef RAYGRID_EVALUATION_RIG_RESULT_H
#define RAYGRID_EVALUATION_RIG_RESULT_H

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "camera/pose.h"
#include "dataset/target_pose.h"
#include "evaluation/calibration_result.h"
#include "evaluation/rigid_target_text.h"

namespace raygrid {

/// The relative pose of two cameras of a rig.
struct Baseline {
  size_t first = 0, second = 0;  ///< camera indices
  int num_shared_views = 0;      ///< frames with a common board
  double distance_m = 0;         ///< distance of their centres
  double angle_rad = 0;          ///< relative rotation angle
  /// Standard deviations of the distance, from the residuals and the normal
  /// equations, and of the rotation (RMS angle).
  std::optional<double> distance_stddev_m, rotation_stddev_rad;
  /// Covariance of the update of second_from_first, as of UpdatedPose():
  /// rotation vector (rad), then translation (m), in the frame of `second`.
  std::optional<PoseCovariance> covariance;
};

/// Two cameras whose relative pose is ambiguous by a symmetry rotation of the
/// board, since all shared views are consistent with both.
struct AmbiguousPair {
  size_t first = 0, second = 0;
  int num_shared_views = 0;
};

/// The calibration result of a rig or a single camera. Each camera's own
/// held-out residuals are from images localized by this camera alone.
struct RigResult {
  std::vector<CalibrationResult> cameras;
  std::vector<Pose> camera_from_rig;   ///< the first is the identity
  Pattern pattern;                     ///< estimated pattern
  std::vector<Baseline> baselines;     ///< one per pair of cameras
  std::vector<BoardPair> board_pairs;  ///< pairs with enough common frames
  std::vector<RigidTarget> rigid_targets;
  std::vector<AmbiguousPair> ambiguous_pairs;
  /// Held-out residuals by camera, with each board localized once per frame by
  /// all cameras that observe it, so that they also evaluate the camera poses.
  std::vector<std::vector<FeatureResidual>> held_out;
  bool cross_validated = false;
  bool converged = false;
  Assessment assessment;
  std::map<std::string, double> seconds;  ///< by stage, total over all cameras

  bool IsRig() const { return cameras.size() > 1; }
};

/// Computes distances and angles, but not standard deviations and views.
std::vector<Baseline> ComputeBaselines(
    const std::vector<Pose>& camera_from_rig);

/// Computes metrics over the residuals of all cameras.
ErrorMetrics ComputeTrainingMetrics(const RigResult& result);
std::optional<ErrorMetrics> ComputeHeldOutMetrics(const RigResult& result);

/// Returns the worst status among the cameras, with the reasons that concern
/// the rig. The status of a single camera is unchanged.
Assessment AssessRig(const RigResult& result);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_RIG_RESULT_H
