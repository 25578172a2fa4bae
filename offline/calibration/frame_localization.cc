#include "calibration/frame_localization.h"

#include <cmath>
#include <utility>

#include "adjustment/bundle_adjustment.h"
#include "calibration/calibration_problem.h"
#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

// Estimates camera_from_pattern of each view from its camera alone.
std::vector<std::optional<Pose>> LocalizeAlone(
    const RigModel& rig, const CalibrationProblem& problem, int num_threads) {
  std::vector<std::optional<Pose>> poses(problem.views.size());
  for (size_t c = 0; c < rig.cameras.size(); ++c) {
    const auto own = LocalizeViews(*rig.cameras[c], static_cast<int>(c),
                                   problem, num_threads);
    for (size_t v = 0; v < poses.size(); ++v)
      if (own[v]) poses[v] = own[v];
  }
  return poses;
}

double ComputeLoss(const AdjustmentState& state,
                   const std::vector<View>& views) {
  constexpr double kHuberPx = 1, kUnseenPx = 1e4;
  double loss = 0;
  for (const Residual& residual : ComputeResiduals(state, views, 1))
    loss += HuberLoss(residual.valid ? residual.error_px.norm() : kUnseenPx,
                      kHuberPx);
  return loss;
}

// Estimates a frame's pose: selects the best of the single-view poses, then
// minimizes the robust cost over all views.
std::optional<Pose> LocalizeTogether(
    const AdjustmentState& rig, const std::vector<View>& views,
    const std::vector<Pose>& rig_from_pattern) {
  if (rig_from_pattern.empty()) return std::nullopt;
  AdjustmentState state = rig, best = rig;
  double best_loss = INFINITY;
  for (const Pose& candidate : rig_from_pattern) {
    state.rig_from_pattern = {candidate};
    const double loss = ComputeLoss(state, views);
    if (loss >= best_loss) continue;
    best_loss = loss;
    best.rig_from_pattern = {candidate};
  }
  AdjustmentOptions options;
  options.fix_cameras = options.fix_points = true;
  options.num_threads = 1;
  RunBundleAdjustment(views, {}, options, &best);
  return best.rig_from_pattern.front();
}

}  // namespace

AdjustmentState MakeAdjustmentState(const RigModel& rig,
                                    const CalibrationProblem& problem) {
  AdjustmentState state;
  for (const CameraModel* camera : rig.cameras)
    state.cameras.push_back(camera->Clone());
  state.camera_from_rig = rig.camera_from_rig;
  state.points = problem.nominal;
  return state;
}

std::vector<std::optional<Pose>> LocalizeProblem(
    const RigModel& rig, const CalibrationProblem& problem, int num_threads,
    const std::vector<Pose>& target_from_board) {
  const auto alone = LocalizeAlone(rig, problem, num_threads);
  std::vector<std::vector<View>> views(problem.num_poses);
  std::vector<std::vector<Pose>> candidates(problem.num_poses);
  for (size_t v = 0; v < problem.views.size(); ++v) {
    View view = problem.views[v];
    const int pose = view.pose;
    if (alone[v])
      candidates[pose].push_back(ComputeTargetPose(
          view, rig.camera_from_rig[view.camera].Inverse() * *alone[v],
          target_from_board));
    view.pose = 0;
    views[pose].push_back(std::move(view));
  }
  AdjustmentState state = MakeAdjustmentState(rig, problem);
  state.target_from_board = target_from_board;
  std::vector<std::optional<Pose>> poses(problem.num_poses);
  ParallelFor(problem.num_poses, NumThreads(num_threads), [&](int p) {
    if (views[p].size() > 1)
      poses[p] = LocalizeTogether(state, views[p], candidates[p]);
    else if (!candidates[p].empty())
      poses[p] = candidates[p].front();
  });
  return poses;
}

LocalizedFrames LocalizeFrames(const RigModel& rig,
                               const std::vector<Dataset>& datasets,
                               const Pattern& pattern, int num_threads) {
  LocalizedFrames frames;
  frames.evaluations.resize(rig.cameras.size());
  std::vector<RejectedImage> rejected;
  frames.problem = BuildProblem(datasets, pattern, &rejected);
  if (datasets.size() == 1)
    frames.evaluations.front().rejected_images = std::move(rejected);
  else
    for (size_t c = 0; c < datasets.size(); ++c)
      BuildProblem({datasets[c]}, pattern,
                   &frames.evaluations[c].rejected_images);
  JoinBoards(rig.rigid_targets, &frames.problem, &frames.target_from_board);
  frames.rig_from_target = LocalizeProblem(rig, frames.problem, num_threads,
                                           frames.target_from_board);
  for (size_t v = 0; v < frames.problem.views.size(); ++v) {
    const View& view = frames.problem.views[v];
    Evaluation& evaluation = frames.evaluations[view.camera];
    const auto& rig_from_target = frames.rig_from_target[view.pose];
    if (!rig_from_target) {
      evaluation.rejected_images.push_back(
          {frames.problem.images[v], "pose estimation failed"});
      continue;
    }
    AddResiduals(*rig.cameras[view.camera],
                 ComputeBoardPose(
                     view, rig.camera_from_rig[view.camera] * *rig_from_target,
                     frames.target_from_board),
                 pattern, frames.problem, static_cast<int>(v), &evaluation);
  }
  return frames;
}

}  // namespace raygrid
