#ifndef RAYGRID_CALIBRATION_RIG_EVALUATION_H
#define RAYGRID_CALIBRATION_RIG_EVALUATION_H

#include <vector>

#include "adjustment/adjustment_state.h"
#include "calibration/camera_evaluation.h"
#include "calibration/rigid_targets.h"
#include "camera/pose.h"

namespace raygrid {

/// Cameras with constant relative poses.
struct RigModel {
  std::vector<const CameraModel*> cameras;
  std::vector<Pose> camera_from_rig;
  RigidTargets rigid_targets = {};  ///< rigid targets of the boards
};

/// Localizes each rigid target or board once per frame, from all cameras that
/// observe it, with a fixed rig; returns the residuals of each camera. Datasets
/// by camera; images of the same name are one frame.
std::vector<Evaluation> EvaluateRig(const RigModel& rig,
                                    const std::vector<Dataset>& datasets,
                                    const Pattern& pattern, int num_threads);

/// Returns camera_from_board of the boards in each camera's images, localized
/// as in EvaluateRig().
std::vector<std::vector<BoardPose>> LocalizeBoards(
    const RigModel& rig, const std::vector<Dataset>& datasets,
    const Pattern& pattern, int num_threads);

/// Returns the rig with a pose per board and frame, localized as by
/// EvaluateRig(). Views that cannot be localized are removed from the problem.
AdjustmentState LocalizeRigViews(const RigModel& rig,
                                 CalibrationProblem* problem, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RIG_EVALUATION_H
