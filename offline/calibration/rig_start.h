#ifndef RAYGRID_CALIBRATION_RIG_START_H
#define RAYGRID_CALIBRATION_RIG_START_H

#include <string>
#include <vector>

#include "calibration/model_adjustment.h"

namespace raygrid {

/// How many views of a board at one instant each two cameras share; a square
/// matrix.
std::vector<std::vector<int>> CountSharedViews(
    const CalibrationProblem& problem);

/// Throws Error(kInitialization) that names the groups of cameras between which
/// there is no shared view, not even through other cameras.
void RequireConnected(const std::vector<std::string>& names,
                      const CalibrationProblem& problem);

/// Puts together cameras that were adjusted alone, each on its own images of
/// the same pattern. The first camera's frame is the rig's. The relative pose
/// of two cameras is the one that explains most of the views that they share;
/// a tree of the pairs that share most leads to all of them. Adjusts all
/// together with the points fixed; views that do not agree with the other
/// cameras' go to rejected, by camera. A single camera stays as it was. Throws
/// Error(kInitialization).
Adjusted PutTogether(const std::vector<std::string>& names,
                     const std::vector<Adjusted>& cameras,
                     const AdjustmentOptions& options,
                     std::vector<std::vector<RejectedImage>>* rejected);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RIG_START_H
