#ifndef RAYGRID_CALIBRATION_RIGID_TARGET_SEARCH_H
#define RAYGRID_CALIBRATION_RIGID_TARGET_SEARCH_H

#include <vector>

#include "calibration/model_adjustment.h"
#include "calibration/rigid_targets.h"
#include "evaluation/rigid_target_text.h"

namespace raygrid {

/// Returns whether two boards are observed in the same frame, by any cameras,
/// often enough to test whether their relative pose is constant.
bool CanDetectRigidTargets(const std::vector<AdjustmentResult>& cameras);

/// Proposes rigid targets of all boards that one camera observes together often
/// enough; their relative poses are not estimated.
RigidTargets ProposeRigidTargets(const std::vector<Dataset>& cameras,
                                 const Pattern& pattern);

/// Compares the relative poses of boards observed in the same frame, in
/// adjustments of independent boards: each of one camera, or of cameras with
/// known poses.
std::vector<BoardPair> CompareBoardPoses(
    const std::vector<AdjustmentResult>& adjusted, const Pattern& pattern,
    int num_threads, RigidTargets* rigid_targets);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RIGID_TARGET_SEARCH_H
