#include "calibration/rig_evaluation.h"

#include <cmath>
#include <optional>
#include <utility>

#include "adjustment/bundle_adjustment.h"
#include "calibration/calibration_problem.h"
#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

AdjustmentState StateOf(const RigModel& rig,
                        const CalibrationProblem& problem) {
  AdjustmentState state;
  for (const CameraModel* camera : rig.cameras)
    state.cameras.push_back(camera->Clone());
  state.camera_from_rig = rig.camera_from_rig;
  state.points = problem.nominal;
  return state;
}

// camera_from_pattern of each view, estimated by its camera alone.
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

double LossOf(const AdjustmentState& state, const std::vector<View>& views) {
  constexpr double kHuberPx = 1, kUnseenPx = 1e4;
  double loss = 0;
  for (const Residual& residual : ComputeResiduals(state, views, 1))
    loss += HuberLoss(residual.valid ? residual.error_px.norm() : kUnseenPx,
                      kHuberPx);
  return loss;
}

// Selects the best of the single views' poses, then minimizes the robust cost
// over all views.
std::optional<Pose> LocalizeTogether(
    const AdjustmentState& rig, const std::vector<View>& views,
    const std::vector<Pose>& rig_from_pattern) {
  if (rig_from_pattern.empty()) return std::nullopt;
  AdjustmentState state = rig, best = rig;
  double best_loss = INFINITY;
  for (const Pose& candidate : rig_from_pattern) {
    state.rig_from_pattern = {candidate};
    const double loss = LossOf(state, views);
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

// Returns rig_from_pattern of each pose.
std::vector<std::optional<Pose>> LocalizeRig(
    const RigModel& rig, const CalibrationProblem& problem, int num_threads,
    const std::vector<Pose>& target_from_board = {}) {
  AdjustmentState state = StateOf(rig, problem);
  state.target_from_board = target_from_board;
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
  std::vector<std::optional<Pose>> poses(problem.num_poses);
  ParallelFor(problem.num_poses, NumThreads(num_threads), [&](int p) {
    poses[p] = LocalizeTogether(state, views[p], candidates[p]);
  });
  return poses;
}

}  // namespace

std::vector<Evaluation> EvaluateRig(const RigModel& rig,
                                    const std::vector<Dataset>& datasets,
                                    const Pattern& pattern, int num_threads) {
  std::vector<Evaluation> evaluations(rig.cameras.size());
  for (size_t c = 0; c < datasets.size(); ++c)
    BuildProblem({datasets[c]}, pattern, &evaluations[c].rejected_images);
  std::vector<RejectedImage> of_all_cameras;
  CalibrationProblem problem = BuildProblem(datasets, pattern, &of_all_cameras);
  std::vector<Pose> target_from_board;
  JoinBoards(rig.rigid_targets, &problem, &target_from_board);
  const auto poses = LocalizeRig(rig, problem, num_threads, target_from_board);
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const View& view = problem.views[v];
    Evaluation& evaluation = evaluations[view.camera];
    if (!poses[view.pose]) {
      evaluation.rejected_images.push_back(
          {problem.images[v], "pose estimation failed"});
      continue;
    }
    AddResiduals(*rig.cameras[view.camera],
                 ComputeBoardPose(
                     view, rig.camera_from_rig[view.camera] * *poses[view.pose],
                     target_from_board),
                 pattern, problem, v, &evaluation);
  }
  return evaluations;
}

std::vector<std::vector<BoardPose>> LocalizeBoards(
    const RigModel& rig, const std::vector<Dataset>& datasets,
    const Pattern& pattern, int num_threads) {
  std::vector<RejectedImage> ignored;
  const CalibrationProblem problem = BuildProblem(datasets, pattern, &ignored);
  const auto poses = LocalizeRig(rig, problem, num_threads);
  std::vector<std::vector<BoardPose>> by_camera(rig.cameras.size());
  for (size_t v = 0; v < problem.views.size(); ++v) {
    const View& view = problem.views[v];
    if (!poses[view.pose]) continue;
    by_camera[view.camera].push_back(
        {problem.images[v], pattern.boards[problem.boards[v]].id,
         rig.camera_from_rig[view.camera] * *poses[view.pose]});
  }
  return by_camera;
}

AdjustmentState LocalizeRigViews(const RigModel& rig,
                                 CalibrationProblem* problem, int num_threads) {
  AdjustmentState state = StateOf(rig, *problem);
  const auto poses = LocalizeRig(rig, *problem, num_threads);
  std::vector<bool> is_lost;
  for (const View& view : problem->views) is_lost.push_back(!poses[view.pose]);
  std::vector<Pose> found;
  for (const auto& pose : poses)
    if (pose) found.push_back(*pose);
  RemoveViews(is_lost, problem);
  state.rig_from_pattern = std::move(found);
  return state;
}

}  // namespace raygrid
