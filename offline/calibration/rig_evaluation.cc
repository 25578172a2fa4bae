#include "calibration/rig_evaluation.h"

#include <optional>
#include <utility>

#include "calibration/calibration_problem.h"
#include "calibration/frame_localization.h"

namespace raygrid {

std::vector<Evaluation> EvaluateRig(const RigModel& rig,
                                    const std::vector<Dataset>& datasets,
                                    const Pattern& pattern, int num_threads) {
  return LocalizeFrames(rig, datasets, pattern, num_threads).evaluations;
}

std::vector<std::vector<BoardPose>> LocalizeBoards(
    const RigModel& rig, const std::vector<Dataset>& datasets,
    const Pattern& pattern, int num_threads) {
  std::vector<RejectedImage> ignored;
  const CalibrationProblem problem = BuildProblem(datasets, pattern, &ignored);
  const auto poses = LocalizeProblem(rig, problem, num_threads);
  std::vector<std::vector<BoardPose>> poses_by_camera(rig.cameras.size());
  for (size_t v = 0; v < problem.views.size(); ++v) {
    const View& view = problem.views[v];
    if (!poses[view.pose]) continue;
    poses_by_camera[view.camera].push_back(
        {problem.images[v], pattern.boards[problem.boards[v]].id,
         rig.camera_from_rig[view.camera] * *poses[view.pose]});
  }
  return poses_by_camera;
}

AdjustmentState LocalizeRigViews(const RigModel& rig,
                                 CalibrationProblem* problem, int num_threads) {
  AdjustmentState state = MakeAdjustmentState(rig, *problem);
  const auto poses = LocalizeProblem(rig, *problem, num_threads);
  std::vector<bool> is_not_localized;
  for (const View& view : problem->views)
    is_not_localized.push_back(!poses[view.pose]);
  std::vector<Pose> found;
  for (const auto& pose : poses)
    if (pose) found.push_back(*pose);
  RemoveViews(is_not_localized, problem);
  state.rig_from_pattern = std::move(found);
  return state;
}

}  // namespace raygrid
