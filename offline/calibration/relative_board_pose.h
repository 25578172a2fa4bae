#ifndef RAYGRID_CALIBRATION_RELATIVE_BOARD_POSE_H
#define RAYGRID_CALIBRATION_RELATIVE_BOARD_POSE_H

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "adjustment/linear_response.h"
#include "calibration/model_adjustment.h"

namespace raygrid {

/// Relative pose of two boards in one frame: the pose of the second board in
/// the frame of the first one.
struct RelativeBoardPose {
  static constexpr int kDimensions = 6;
  using Vector = Eigen::Matrix<double, 6, 1>;
  using Matrix = Eigen::Matrix<double, 6, 6>;

  std::string image;
  int first_pose = 0, second_pose = 0;
  Pose rig_from_first;
  Eigen::Quaterniond relative_rotation;
  Eigen::Vector3d center;           ///< centre of the second board
  Vector J_scale = Vector::Zero();  ///< Jacobian with respect to the second
                                    ///< board's scale, if it is free
  /// Jacobians of rotation and centre with respect to UpdatedPose()'s updates.
  Matrix J_first = Matrix::Zero(), J_second = Matrix::Zero();
  Matrix covariance = Matrix::Zero(), information = Matrix::Zero();
};

/// Mean pose of the second board; scale of the first board relative to the
/// second board's.
struct MeanRelativePose {
  Eigen::Quaterniond relative_rotation;
  Eigen::Vector3d center;
  double scale = 0;
};

/// Squared Mahalanobis distance beyond which a relative pose is an outlier: the
/// 99.9 % quantile of chi-square with six degrees of freedom, times two, since
/// covariances are only approximate, e.g. if a grid is too coarse for its lens.
constexpr double kCovarianceMargin = 2,
                 kMaxSquaredMahalanobis = kCovarianceMargin * 22.458;

RelativeBoardPose::Vector ComputeDeviation(
    const MeanRelativePose& mean, const RelativeBoardPose& relative_pose);
double SquaredMahalanobis(const MeanRelativePose& mean,
                          const RelativeBoardPose& relative_pose);

/// Computes the mean weighted by information; outliers have less weight.
MeanRelativePose ComputeRobustMean(
    const std::vector<RelativeBoardPose>& relative_poses);

/// Removes relative poses with a poorly determined rotation: a single row of
/// features does not determine the rotation about the row.
void RemoveUndetermined(std::vector<RelativeBoardPose>* relative_poses);

/// Computes the relative poses of two boards in an adjustment, without
/// covariances; at most max_count, evenly selected.
/// @param middle centre of the second board, in its frame
std::vector<RelativeBoardPose> ComputeRelativePoses(
    const AdjustmentResult& adjusted, int first, int second,
    const Eigen::Vector3d& center, size_t max_count);

/// Covariances of the poses of an adjustment, including the uncertainty of the
/// camera and the points and all their priors.
class PoseEquations {
 public:
  PoseEquations(const AdjustmentResult& adjusted, const Pattern& pattern,
                int num_threads);

  /// Returns the maximum number of relative poses per pair of boards, which
  /// limits the run time.
  size_t MaxNumRelativePoses() const { return response_.IsExact() ? 60 : 16; }

  /// Computes the covariances of relative poses. Correlated noise is not
  /// averaged: n features with residual correlation c multiply covariances by 1
  /// + c n / 3. Returns false if the equations are singular.
  bool AddCovariances(std::vector<RelativeBoardPose>* relative_poses) const;

 private:
  LinearResponse response_;
  double variance_, correlation_ = 0;
  std::vector<double> num_features_;  // by pose
};

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RELATIVE_BOARD_POSE_H
