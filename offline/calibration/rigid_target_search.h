#ifndef RAYGRID_CALIBRATION_RIGID_TARGET_SEARCH_H
#define RAYGRID_CALIBRATION_RIGID_TARGET_SEARCH_H

#include <vector>

#include "calibration/model_adjustment.h"
#include "calibration/rigid_targets.h"
#include "evaluation/rigid_target_text.h"

namespace raygrid {

/// Whether two boards are seen at one instant, by whichever cameras, often
/// enough to tell whether they are fixed to each other.
bool CanDetectRigidTargets(const std::vector<AdjustmentResult>& cameras);

/// Bodies of all boards that may be fixed to each other for how often one of
/// the cameras sees them together; their places are not known.
RigidTargets ProposeRigidTargets(const std::vector<Dataset>& cameras,
                                 const Pattern& pattern);

/// How the boards stood to each other that were seen at one instant, in
/// adjustments of boards that move by themselves: each of one camera, or of
/// cameras whose poses are known.
std::vector<BoardPair> CompareBoardPoses(
    const std::vector<AdjustmentResult>& adjusted, const Pattern& pattern,
    int num_threads, RigidTargets* rigid_targets);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RIGID_TARGET_SEARCH_H
