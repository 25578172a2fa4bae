#ifndef RAYGRID_HAND_EYE_HAND_EYE_REFINEMENT_H
#define RAYGRID_HAND_EYE_HAND_EYE_REFINEMENT_H

#include <optional>
#include <vector>

#include "hand_eye/hand_eye_model.h"

namespace raygrid {

/// Stated accuracy of the robot, per axis; estimated if not given.
struct StatedRobotNoise {
  std::optional<double> rotation_rad, translation_m;
};

/// Noise below which a robot is exact: variances remain positive.
constexpr RobotNoise kMinRobotNoise = {1e-7, 1e-7};

/// A maximum-likelihood solution.
struct HandEyeFit {
  HandEye hand_eye;
  RobotNoise noise;
  /// Covariance of the updates of camera_from_mount and anchor_from_target.
  Matrix12d covariance = Matrix12d::Zero();
  bool converged = false;
};

/// Estimates both transformations, with the robot's noise unless it is stated,
/// from a subset of the observations.
///
/// This minimizes the reprojection errors over both transformations and one
/// robot pose per image, each with its own prior: the true robot poses are
/// eliminated, which adds their noise to the covariance of each target pose,
/// and the reprojection errors of an image are replaced by their second-order
/// expansion at its target pose. Variances follow by restricted maximum
/// likelihood (Patterson and Thompson, 1971), without the bias by the 12
/// estimated parameters. nullopt if the observations do not determine the
/// transformations.
std::optional<HandEyeFit> RefineHandEye(
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    const std::vector<int>& subset, const HandEyeFit& start,
    const StatedRobotNoise& stated);

/// Returns the inverse of a symmetric positive definite matrix; nullopt if it
/// is numerically singular. Rows are scaled, so units do not matter.
std::optional<Eigen::MatrixXd> InvertScaled(const Eigen::MatrixXd& matrix);

/// Squared Mahalanobis distance of an observation from its prediction, and the
/// covariance of the difference. is_used: the observation is one of those that
/// the fit is based on.
struct HandEyeDistance {
  Vector6d error;
  PoseCovariance covariance;
  double squared = 0;
};
HandEyeDistance MeasureDistance(const HandEyeFit& fit, Mounting mounting,
                                const HandEyeObservation& observation,
                                bool is_used);

/// Scale of the robot's lengths relative to the target's minus one, estimated
/// with the other parameters, and its standard deviation.
struct ScaleError {
  double value = 0, stddev = 0;
};
std::optional<ScaleError> EstimateScale(
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    const std::vector<int>& subset, const HandEyeFit& fit);

}  // namespace raygrid

#endif  // RAYGRID_HAND_EYE_HAND_EYE_REFINEMENT_H
