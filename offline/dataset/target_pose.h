#ifndef RAYGRID_DATASET_TARGET_POSE_H
#define RAYGRID_DATASET_TARGET_POSE_H

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "dataset/dataset.h"

namespace raygrid {

using PoseCovariance = Eigen::Matrix<double, 6, 6>;

/// The pose of a target in a frame, estimated with fixed intrinsics.
struct TargetPose {
  /// Image name, and the board that defines the target's frame.
  BoardPose pose;
  /// Covariance of the update of UpdatedPose(), in the camera's axes: rotation
  /// vector (rad), then translation (m).
  PoseCovariance covariance = PoseCovariance::Zero();
  int num_features = 0;
  double rms_px = 0;

  /// Returns the standard deviation of the rotation (RMS angle, rad) and of the
  /// translation (RMS length, m).
  double RotationStdDev() const;
  double TranslationStdDev() const;
};

/// Returns the covariance of b_from_a * pose, for the covariance of a pose in
/// frame a.
PoseCovariance RotateCovariance(const Pose& b_from_a,
                                const PoseCovariance& covariance);

/// Formats poses.csv with the number of features, the RMS reprojection error
/// and the upper triangle of the covariance. The first column is the camera's
/// name, unless it is empty.
std::string FormatTargetPoses(const std::string& camera,
                              const std::vector<TargetPose>& poses);

/// Parses poses.csv, keyed by camera name; "" if the file has no camera column.
/// path is used in errors. Throws InputError if the file is malformed, a
/// covariance is not positive definite, or a target is repeated in an image.
std::map<std::string, std::vector<TargetPose>> ParseTargetPoses(
    const std::string& path, const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_TARGET_POSE_H
