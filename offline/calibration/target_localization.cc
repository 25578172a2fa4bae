#include "calibration/target_localization.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "adjustment/view_jacobian.h"
#include "calibration/frame_localization.h"
#include "calibration/model_adjustment.h"
#include "calibration/outlier_removal.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

constexpr double kPoseHuberPx = 1;

// Normal equations of a target pose in a frame, with Huber weights.
struct PoseInformation {
  PoseCovariance matrix = PoseCovariance::Zero();  // J^T J
  double sum = 0, weight = 0;  // weighted sum of squares; weighted coordinates
  int view = -1;               // first view of the pose
  int num_features = 0;

  double DegreesOfFreedom() const { return std::max(weight - 6, 0.0); }
};

void AddPoseInformation(const AdjustmentState& state, const View& view,
                        int index, PoseInformation* information) {
  const std::vector<LinearizedResidual> residuals = LinearizeView(state, view);
  const ViewJacobian jacobian = WeightedJacobian(residuals, kPoseHuberPx);
  if (information->view < 0) information->view = index;
  information->matrix += jacobian.J_pose * jacobian.J_pose.transpose();
  information->sum += jacobian.error.squaredNorm();
  for (const LinearizedResidual& linear : residuals) {
    if (!linear.residual.valid) continue;
    information->weight +=
        2 * HuberWeight(linear.residual.error_px.norm(), kPoseHuberPx);
    ++information->num_features;
  }
}

std::vector<PoseInformation> GatherInformation(const LocalizedFrames& frames,
                                               const AdjustmentState& state) {
  const CalibrationProblem& problem = frames.problem;
  std::vector<PoseInformation> information(problem.num_poses);
  for (size_t v = 0; v < problem.views.size(); ++v) {
    const View& view = problem.views[v];
    if (frames.rig_from_target[view.pose])
      AddPoseInformation(state, view, static_cast<int>(v),
                         &information[view.pose]);
  }
  return information;
}

double PooledVariance(const std::vector<PoseInformation>& information) {
  double sum = 0, degrees_of_freedom = 0;
  for (const PoseInformation& pose : information) {
    sum += pose.sum;
    degrees_of_freedom += pose.DegreesOfFreedom();
  }
  return degrees_of_freedom > 0 ? sum / degrees_of_freedom : 0;
}

// Returns the noise variance of one pose. Images differ in sharpness, but a few
// features determine the variance poorly, so the pooled variance over all poses
// contributes with the weight of ten features.
double ComputeResidualVariance(const PoseInformation& pose, double pooled) {
  constexpr double kPooledDegrees = 20;
  return (kPooledDegrees * pooled + pose.sum) /
         (kPooledDegrees + pose.DegreesOfFreedom());
}

// Inverts an information matrix; nullopt if it is numerically singular.
// Parameters are scaled, so that rotations and translations are comparable.
std::optional<PoseCovariance> InvertInformation(
    const PoseCovariance& information) {
  constexpr double kMinEigenvalueRatio = 1e-12;
  const Eigen::Matrix<double, 6, 1> scale =
      information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<PoseCovariance> solver(
      scale.asDiagonal() * information * scale.asDiagonal());
  if (!(solver.eigenvalues()[0] > kMinEigenvalueRatio)) return std::nullopt;
  const PoseCovariance vectors = scale.asDiagonal() * solver.eigenvectors();
  return PoseCovariance(vectors *
                        solver.eigenvalues().cwiseInverse().asDiagonal() *
                        vectors.transpose());
}

// Returns the index of the board that defines the frame of a view's target.
int FrameBoard(const CalibrationProblem& problem, int view) {
  const int board = problem.boards[view];
  return problem.views[view].place < 0 ? board : problem.frames[board];
}

// Converts estimated poses to an adjustment result, and drops views without a
// pose.
AdjustmentResult MakeAdjustmentProblem(const RigModel& rig,
                                       LocalizedFrames frames) {
  AdjustmentResult adjusted;
  std::vector<bool> is_lost;
  for (const View& view : frames.problem.views)
    is_lost.push_back(!frames.rig_from_target[view.pose]);
  adjusted.problem = std::move(frames.problem);
  RemoveViews(is_lost, &adjusted.problem);
  adjusted.state = MakeAdjustmentState(rig, adjusted.problem);
  adjusted.state.target_from_board = std::move(frames.target_from_board);
  for (const auto& pose : frames.rig_from_target)
    if (pose) adjusted.state.rig_from_pattern.push_back(*pose);
  adjusted.rejected_features.resize(rig.cameras.size());
  adjusted.prior.points_mean = adjusted.problem.nominal;
  return adjusted;
}

// Returns the sum of the distances of a rig's cameras from its origin; 1 if the
// sum is zero.
double ComputeScale(const std::vector<Pose>& camera_from_rig) {
  double sum = 0;
  for (const Pose& pose : camera_from_rig) sum += pose.translation.norm();
  return sum > 0 ? sum : 1;
}

void ScaleTargets(double scale, Pattern* pattern) {
  for (Board& board : pattern->boards)
    for (Eigen::Vector3d& point : board.points) point *= scale;
  for (RigidTarget& target : pattern->rigid_targets)
    for (Pose& pose : target.first_from_board) pose.translation *= scale;
}

// Lists the rigid targets with more than one board for a pattern.
std::vector<RigidTarget> ListRigidTargets(const Pattern& pattern,
                                          const RigidTargets& rigid_targets) {
  std::vector<RigidTarget> list;
  for (const std::vector<int>& group : rigid_targets.Groups()) {
    RigidTarget& target = list.emplace_back();
    for (const int b : group) {
      target.boards.push_back(pattern.boards[b].id);
      target.first_from_board.push_back(
          rigid_targets.frame_from_board[group.front()].Inverse() *
          rigid_targets.frame_from_board[b]);
    }
  }
  return list;
}

}  // namespace

TargetLocalization LocalizeTargets(const RigModel& rig,
                                   const std::vector<Dataset>& datasets,
                                   const Pattern& pattern, int num_threads) {
  LocalizedFrames frames = LocalizeFrames(rig, datasets, pattern, num_threads);
  const CalibrationProblem& problem = frames.problem;
  AdjustmentState state = MakeAdjustmentState(rig, problem);
  state.target_from_board = frames.target_from_board;
  for (const auto& pose : frames.rig_from_target)
    state.rig_from_pattern.push_back(pose.value_or(Pose()));
  const std::vector<PoseInformation> information =
      GatherInformation(frames, state);
  const double pooled = PooledVariance(information);

  TargetLocalization result;
  result.cameras = std::move(frames.evaluations);
  result.noise_px = std::sqrt(pooled);
  for (size_t p = 0; p < information.size(); ++p) {
    const PoseInformation& own = information[p];
    if (own.view < 0) continue;
    const std::string& image = problem.images[own.view];
    const auto inverse = InvertInformation(own.matrix);
    if (!inverse) {
      result.cameras[problem.views[own.view].camera].rejected_images.push_back(
          {image, "the features do not determine the pose"});
      continue;
    }
    TargetPose& target = result.poses.emplace_back();
    target.pose = {image, pattern.boards[FrameBoard(problem, own.view)].id,
                   *frames.rig_from_target[p]};
    target.covariance = ComputeResidualVariance(own, pooled) * *inverse;
    target.num_features = own.num_features;
    target.rms_px = std::sqrt(2 * own.sum / own.weight);
  }
  return result;
}

Pattern EstimateTargetGeometry(const RigModel& rig,
                               const std::vector<Dataset>& datasets,
                               const Pattern& pattern, int num_threads) {
  AdjustmentResult adjusted = MakeAdjustmentProblem(
      rig, LocalizeFrames(rig, datasets, pattern, num_threads));
  AdjustmentState& state = adjusted.state;
  if (static_cast<int>(state.rig_from_pattern.size()) < kMinTargetPoses)
    throw Error(ExitCode::kInsufficientData,
                fmt::format("cannot estimate the target geometry: {} of at "
                            "least {} poses; use more images",
                            state.rig_from_pattern.size(), kMinTargetPoses));
  AdjustmentOptions options;
  options.fix_cameras = true;
  options.num_threads = num_threads;
  state.SetModes(GetDeformationModes(adjusted.problem),
                 DeformationScope::kBoard);
  const auto optimize = [&] {
    adjusted.summary = OptimizeWithLearnedPrior(adjusted.problem.views, options,
                                                &adjusted.prior, &state);
  };
  optimize();
  if (RemoveOutliers(pattern, &adjusted) != RemovalResult::kNone) optimize();
  AlignBoards(pattern, &adjusted);
  Pattern estimated = MakeEstimatedPattern(pattern, adjusted);
  if (!rig.rigid_targets.empty())
    estimated.rigid_targets = ListRigidTargets(
        pattern, UpdateRigidTargets(rig.rigid_targets, adjusted.problem,
                                    state.target_from_board));
  // AlignBoards() scaled the rig to the nominal target; restores the scale of
  // the rig.
  ScaleTargets(
      ComputeScale(rig.camera_from_rig) / ComputeScale(state.camera_from_rig),
      &estimated);
  return estimated;
}

}  // namespace raygrid
