#ifndef RAYGRID_CALIBRATION_RIG_INITIALIZATION_H
#define RAYGRID_CALIBRATION_RIG_INITIALIZATION_H

#include <string>
#include <vector>

#include "calibration/board_rotations.h"
#include "calibration/model_adjustment.h"
#include "calibration/rigid_targets.h"
#include "evaluation/rig_result.h"

namespace raygrid {

/// How often each two cameras see one body at one instant; a square matrix.
std::vector<std::vector<int>> CountSharedViews(
    const CalibrationProblem& problem);

/// The groups of cameras that such instants connect.
std::vector<std::vector<int>> ConnectedGroups(
    const CalibrationProblem& problem);

/// The groups of cameras, adjusted alone, that InitializeRig() can put together
/// without bodies.
std::vector<std::vector<int>> ConnectedGroups(
    const std::vector<AdjustmentResult>& cameras);

/// Throws Error(kInitialization) that names the groups of cameras between which
/// there is no shared view, not even through other cameras.
void RequireConnected(const std::vector<std::string>& names,
                      const CalibrationProblem& problem);

/// How boards that look alike after a turn are turned in the images of some
/// cameras, so that the cameras agree, and where two turns agree as well.
struct RigRotations {
  std::vector<BoardRotations> by_camera;
  std::vector<AmbiguousPair> ambiguous;
};
/// Cameras, adjusted alone, whose views' boards may each be turned. Of each
/// instant, the camera that is connected first says how a board stands.
RigRotations ResolveRotationsAcrossCameras(
    const std::vector<AdjustmentResult>& cameras, const Pattern& pattern,
    int num_threads);

/// Puts together cameras that were adjusted alone, each on its own images of
/// the same pattern, and boards into the bodies that they belong to. The first
/// camera's frame is the rig's. The relative pose of two cameras is the one
/// that explains most of the views that they share; a tree of the pairs that
/// share most leads to all of them. Adjusts all together with the points fixed;
/// views that do not agree with the other cameras', or of other boards of their
/// body, go to rejected, by camera. A single camera without bodies stays as it
/// was. Throws Error(kInitialization).
AdjustmentResult InitializeRig(
    const std::vector<std::string>& names,
    const std::vector<AdjustmentResult>& cameras,
    const RigidTargets& rigid_targets, const AdjustmentOptions& options,
    std::vector<std::vector<RejectedImage>>* rejected);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RIG_INITIALIZATION_H
