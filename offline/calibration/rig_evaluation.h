#ifndef RAYGRID_CALIBRATION_RIG_EVALUATION_H
#define RAYGRID_CALIBRATION_RIG_EVALUATION_H

#include <vector>

#include "adjustment/adjustment_state.h"
#include "calibration/camera_evaluation.h"
#include "calibration/rigid_targets.h"
#include "camera/pose.h"

namespace raygrid {

/// Cameras that do not move against each other.
struct RigModel {
  std::vector<const CameraModel*> cameras;
  std::vector<Pose> camera_from_rig;
  RigidTargets rigid_targets = {};  ///< that boards in front of it belong to
};

/// Each body, or board, localised once for an instant, by all cameras that see
/// it, with the rig as it is; what each camera's residuals are then. Datasets
/// by camera; images of one name are one instant.
std::vector<Evaluation> EvaluateRig(const RigModel& rig,
                                    const std::vector<Dataset>& datasets,
                                    const Pattern& pattern, int num_threads);

/// camera_from_board of the boards in each camera's images, which are localised
/// likewise.
std::vector<std::vector<BoardPose>> LocalizeBoards(
    const RigModel& rig, const std::vector<Dataset>& datasets,
    const Pattern& pattern, int num_threads);

/// The rig with a pose for each board at each instant, as EvaluateRig()
/// localises them. Views that cannot be localised leave the problem.
AdjustmentState LocalizeRigViews(const RigModel& rig,
                                 CalibrationProblem* problem, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RIG_EVALUATION_H
