#ifndef RAYGRID_CALIBRATION_FRAME_LOCALIZATION_H
#define RAYGRID_CALIBRATION_FRAME_LOCALIZATION_H

#include <optional>
#include <vector>

#include "calibration/rig_evaluation.h"

namespace raygrid {

/// Returns a rig's cameras and the problem's points, without poses.
AdjustmentState MakeAdjustmentState(const RigModel& rig,
                                    const CalibrationProblem& problem);

/// Estimates rig_from_target for each pose of a problem (View::pose) with a
/// fixed rig; nullopt if this fails. Several views of a pose are optimized
/// together.
std::vector<std::optional<Pose>> LocalizeProblem(
    const RigModel& rig, const CalibrationProblem& problem, int num_threads,
    const std::vector<Pose>& target_from_board = {});

/// The poses of rigid targets or boards, one per frame, and the residuals of
/// each camera.
struct LocalizedFrames {
  CalibrationProblem problem;  ///< with the boards of rigid targets joined
  std::vector<Pose> target_from_board;  ///< AdjustmentState::target_from_board
  std::vector<std::optional<Pose>> rig_from_target;  ///< by View::pose
  std::vector<Evaluation> evaluations;               ///< by camera
};

/// Localizes each rigid target or board once per frame, from all cameras that
/// observe it, with a fixed rig. Datasets by camera; images of the same name
/// are one frame.
LocalizedFrames LocalizeFrames(const RigModel& rig,
                               const std::vector<Dataset>& datasets,
                               const Pattern& pattern, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_FRAME_LOCALIZATION_H
