#include "calibration/relative_board_pose.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "calibration/camera_result.h"
#include "calibration/even_selection.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

constexpr int kDimensions = RelativeBoardPose::kDimensions;

// Returns the index of each board's pose, by image and board.
std::map<std::string, std::map<int, int>> GroupPosesByImage(
    const CalibrationProblem& problem) {
  std::map<std::string, std::map<int, int>> poses;
  for (size_t v = 0; v < problem.views.size(); ++v)
    poses[problem.images[v]][problem.boards[v]] = problem.views[v].pose;
  return poses;
}

Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

RelativeBoardPose ComputeRelativeBoardPose(const std::string& image,
                                           int first_pose, int second_pose,
                                           const AdjustmentState& state,
                                           const Eigen::Vector3d& center,
                                           bool scale_is_free) {
  const Pose& first = state.rig_from_pattern[first_pose];
  const Pose& second = state.rig_from_pattern[second_pose];
  RelativeBoardPose relative_pose;
  relative_pose.image = image;
  relative_pose.first_pose = first_pose;
  relative_pose.second_pose = second_pose;
  relative_pose.rig_from_first = first;
  const Eigen::Matrix3d back = first.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d turned = second.rotation * center;
  const Eigen::Vector3d center_in_rig = turned + second.translation;
  const Eigen::Vector3d offset = center_in_rig - first.translation;
  relative_pose.relative_rotation =
      first.rotation.conjugate() * second.rotation;
  relative_pose.center = back * offset;
  if (scale_is_free) relative_pose.J_scale.tail<3>() = back * center_in_rig;
  relative_pose.J_first.topLeftCorner<3, 3>() = -back;
  relative_pose.J_first.bottomLeftCorner<3, 3>() = back * CrossMatrix(offset);
  relative_pose.J_first.bottomRightCorner<3, 3>() = -back;
  relative_pose.J_second.topLeftCorner<3, 3>() = back;
  relative_pose.J_second.bottomLeftCorner<3, 3>() = -back * CrossMatrix(turned);
  relative_pose.J_second.bottomRightCorner<3, 3>() = back;
  return relative_pose;
}

// Returns the relative pose of the frame that is most consistent with all
// frames.
MeanRelativePose EstimateConsensusPose(
    const std::vector<RelativeBoardPose>& relative_poses) {
  constexpr size_t kMaxCandidates = 100;
  const size_t step = relative_poses.size() / kMaxCandidates + 1;
  MeanRelativePose best;
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < relative_poses.size(); i += step) {
    const MeanRelativePose candidate = {relative_poses[i].relative_rotation,
                                        relative_poses[i].center, 0};
    std::vector<double> squares;
    for (const RelativeBoardPose& relative_pose : relative_poses)
      squares.push_back(SquaredMahalanobis(candidate, relative_pose));
    const double median = Quantile(squares, 0.5);
    if (!(median < least)) continue;
    least = median;
    best = candidate;
  }
  return best;
}

AdjustmentOptions MakeFrameOptions(const AdjustmentResult& adjusted,
                                   int num_threads) {
  AdjustmentOptions options;
  options.fix_points = !HavePointsMoved(adjusted);
  options.num_threads = num_threads;
  return options;
}

}  // namespace

RelativeBoardPose::Vector ComputeDeviation(
    const MeanRelativePose& mean, const RelativeBoardPose& relative_pose) {
  Eigen::Quaterniond relative_rotation =
      relative_pose.relative_rotation * mean.relative_rotation.conjugate();
  if (relative_rotation.w() < 0)
    relative_rotation.coeffs() = -relative_rotation.coeffs();
  const Eigen::AngleAxisd angle_axis(relative_rotation);
  RelativeBoardPose::Vector deviation;
  deviation << angle_axis.angle() * angle_axis.axis(),
      relative_pose.center - mean.center;
  return deviation + mean.scale * relative_pose.J_scale;
}

double SquaredMahalanobis(const MeanRelativePose& mean,
                          const RelativeBoardPose& relative_pose) {
  const RelativeBoardPose::Vector deviation =
      ComputeDeviation(mean, relative_pose);
  return deviation.dot(relative_pose.information * deviation);
}

MeanRelativePose ComputeRobustMean(
    const std::vector<RelativeBoardPose>& relative_poses) {
  constexpr int kRounds = 20;
  MeanRelativePose mean = EstimateConsensusPose(relative_poses);
  const bool has_scale = !relative_poses.front().J_scale.isZero();
  const int size = has_scale ? kDimensions + 1 : kDimensions;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(size);
    for (const RelativeBoardPose& relative_pose : relative_poses) {
      const RelativeBoardPose::Vector deviation =
          ComputeDeviation(mean, relative_pose);
      const double square =
          deviation.dot(relative_pose.information * deviation);
      const double weight = std::min(1.0, kMaxSquaredMahalanobis / square);
      Eigen::MatrixXd by(kDimensions, size);
      by.leftCols<kDimensions>() = -RelativeBoardPose::Matrix::Identity();
      if (has_scale) by.col(kDimensions) = relative_pose.J_scale;
      h += weight * by.transpose() * relative_pose.information * by;
      g += weight * by.transpose() * relative_pose.information * deviation;
    }
    const Eigen::VectorXd step = -h.ldlt().solve(g);
    mean.relative_rotation =
        (RotationFromVector(step.head<3>()) * mean.relative_rotation)
            .normalized();
    mean.center += step.segment<3>(3);
    if (has_scale) mean.scale += step[kDimensions];
  }
  return mean;
}

void RemoveUndetermined(std::vector<RelativeBoardPose>* relative_poses) {
  constexpr double kMaxRotationStdDevRad = 5 * M_PI / 180;
  relative_poses->erase(
      std::remove_if(
          relative_poses->begin(), relative_poses->end(),
          [](const RelativeBoardPose& relative_pose) {
            const double square =
                relative_pose.covariance.topLeftCorner<3, 3>().trace();
            return !(square <= kMaxRotationStdDevRad * kMaxRotationStdDevRad) ||
                   relative_pose.covariance.llt().info() != Eigen::Success;
          }),
      relative_poses->end());
}

std::vector<RelativeBoardPose> ComputeRelativePoses(
    const AdjustmentResult& adjusted, int first, int second,
    const Eigen::Vector3d& center, size_t max_count) {
  const bool scale_is_free =
      HavePointsMoved(adjusted) && adjusted.state.cameras.size() == 1;
  std::vector<RelativeBoardPose> relative_poses;
  for (const auto& [image, poses] : GroupPosesByImage(adjusted.problem)) {
    const auto a = poses.find(first), b = poses.find(second);
    if (a != poses.end() && b != poses.end())
      relative_poses.push_back(ComputeRelativeBoardPose(
          image, a->second, b->second, adjusted.state, center, scale_is_free));
  }
  return SelectEvenly(relative_poses, max_count);
}

PoseEquations::PoseEquations(const AdjustmentResult& adjusted,
                             const Pattern& pattern, int num_threads)
    : response_(adjusted.problem.views, adjusted.prior,
                MakeFrameOptions(adjusted, num_threads), adjusted.state) {
  // Camera models have errors of at least this size, even with exact features.
  constexpr double kMinNoisePx = 0.01;
  variance_ = std::pow(std::max(adjusted.summary.noise_px, kMinNoisePx), 2);
  const int num_cameras = static_cast<int>(adjusted.state.cameras.size());
  for (int c = 0; c < num_cameras; ++c)
    correlation_ = std::max(
        correlation_,
        ComputeNeighborCorrelation(
            ComputeTrainingResiduals(pattern, adjusted, c, num_threads))
            .value_or(0));
  num_features_.resize(adjusted.problem.num_poses);
  for (const View& view : adjusted.problem.views)
    num_features_[view.pose] += static_cast<double>(view.observations.size());
}

bool PoseEquations::AddCovariances(
    std::vector<RelativeBoardPose>* relative_poses) const {
  const ParameterLayout& layout = response_.layout();
  const auto count = static_cast<Eigen::Index>(relative_poses->size());
  Eigen::MatrixXd right =
      Eigen::MatrixXd::Zero(layout.num_all(), kDimensions * count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto& relative_pose = (*relative_poses)[i];
    auto columns = right.middleCols<kDimensions>(kDimensions * i);
    columns.middleRows<kDimensions>(layout.Pose(relative_pose.first_pose)) =
        relative_pose.J_first.transpose();
    columns.middleRows<kDimensions>(layout.Pose(relative_pose.second_pose)) =
        relative_pose.J_second.transpose();
  }
  Eigen::MatrixXd solution;
  if (!response_.Solve(right, &solution)) return false;
  for (Eigen::Index i = 0; i < count; ++i) {
    auto& relative_pose = (*relative_poses)[i];
    const RelativeBoardPose::Matrix inverse =
        right.middleCols<kDimensions>(kDimensions * i).transpose() *
        solution.middleCols<kDimensions>(kDimensions * i);
    const double features = std::min(num_features_[relative_pose.first_pose],
                                     num_features_[relative_pose.second_pose]);
    relative_pose.covariance = variance_ * (1 + features / 3 * correlation_) *
                               (inverse + inverse.transpose()) / 2;
    relative_pose.information = relative_pose.covariance.ldlt().solve(
        RelativeBoardPose::Matrix::Identity());
  }
  return true;
}

}  // namespace raygrid
