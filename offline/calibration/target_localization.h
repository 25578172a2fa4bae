#ifndef RAYGRID_CALIBRATION_TARGET_LOCALIZATION_H
#define RAYGRID_CALIBRATION_TARGET_LOCALIZATION_H

#include <optional>
#include <vector>

#include "calibration/rig_evaluation.h"
#include "dataset/target_pose.h"

namespace raygrid {

/// The poses of all targets in all frames, relative to the rig, and the
/// residuals of each camera.
struct TargetLocalization {
  std::vector<TargetPose> poses;
  std::vector<Evaluation> cameras;
  /// Standard deviation of a feature's coordinate, over all poses.
  double noise_px = 0;
};

/// Localizes targets like EvaluateRig(). Covariances assume white reprojection
/// errors, and fixed cameras and target geometry.
TargetLocalization LocalizeTargets(const RigModel& rig,
                                   const std::vector<Dataset>& datasets,
                                   const Pattern& pattern, int num_threads);

/// Minimum number of poses for estimating the target geometry.
constexpr int kMinTargetPoses = 3;

/// Returns the pattern with estimated points, and estimated relative poses of
/// the boards of rigid targets, for fixed cameras. The scale of the target is
/// estimated with a rig or a non-central camera; with a central camera, the
/// nominal scale is kept. Throws Error(kInsufficientData).
Pattern EstimateTargetGeometry(const RigModel& rig,
                               const std::vector<Dataset>& datasets,
                               const Pattern& pattern, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_TARGET_LOCALIZATION_H
