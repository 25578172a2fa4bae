#ifndef RAYGRID_CALIBRATION_RIG_INITIALIZATION_H
#define RAYGRID_CALIBRATION_RIG_INITIALIZATION_H

#include <string>
#include <vector>

#include "calibration/board_rotations.h"
#include "calibration/model_adjustment.h"
#include "calibration/rigid_targets.h"
#include "evaluation/rig_result.h"

namespace raygrid {

/// Counts the frames with shared targets of each two cameras (square matrix).
std::vector<std::vector<int>> CountSharedViews(
    const CalibrationProblem& problem);

/// Returns the groups of cameras that frames with shared targets connect.
std::vector<std::vector<int>> ConnectedGroups(
    const CalibrationProblem& problem);

/// Groups cameras, adjusted alone, that InitializeRig() can connect without
/// rigid targets.
std::vector<std::vector<int>> ConnectedGroups(
    const std::vector<AdjustmentResult>& cameras);

/// Throws Error(kInitializationFailed), naming the groups of cameras, unless
/// all cameras are connected by shared views, directly or through other
/// cameras.
void RequireConnected(const std::vector<std::string>& names,
                      const CalibrationProblem& problem);

/// Rotations of symmetric boards in the images of each camera for which the
/// cameras agree, and pairs for which two rotations agree equally well.
struct RigRotations {
  std::vector<BoardRotations> by_camera;
  std::vector<AmbiguousPair> ambiguous;
};
/// Estimates rotations for cameras that were adjusted alone. In each frame, the
/// camera that is connected first determines the rotation of a board.
RigRotations ResolveRotationsAcrossCameras(
    const std::vector<AdjustmentResult>& cameras, const Pattern& pattern,
    int num_threads);

/// Combines cameras that were adjusted alone, each on its own images of the
/// same pattern, to a rig, and boards to rigid targets. The rig's frame is the
/// first camera's. For each pair of cameras, uses the relative pose that
/// explains most of their shared views. The pairs with the most shared views
/// form a tree that connects all cameras. Optimizes everything with fixed
/// points; views that are inconsistent with other cameras, or other boards of
/// their target, are added to rejected, by camera. A single camera without
/// rigid targets is unchanged. Throws Error(kInitializationFailed).
AdjustmentResult InitializeRig(
    const std::vector<std::string>& names,
    const std::vector<AdjustmentResult>& cameras,
    const RigidTargets& rigid_targets, const AdjustmentOptions& options,
    std::vector<std::vector<RejectedImage>>* rejected);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RIG_INITIALIZATION_H
