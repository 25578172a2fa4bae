#ifndef RAYGRID_CALIBRATION_RIG_MOTION_H
#define RAYGRID_CALIBRATION_RIG_MOTION_H

#include <string>
#include <vector>

#include "calibration/adjustment_result.h"
#include "calibration/rigid_targets.h"
#include "evaluation/rigid_target_text.h"

namespace raygrid {

/// Minimum number of frames in which two groups of cameras observe two targets.
constexpr int kMinMotionFrames = 4;

/// Whether groups of cameras without shared views have enough common frames to
/// be connected by the motion of the rig.
bool CanConnectByMotion(const CalibrationProblem& problem,
                        const std::vector<std::vector<int>>& groups);

/// Connects groups of cameras that never observe a common target: while the rig
/// moves, two groups observe two targets that are fixed to each other, so that
/// their relative motions fulfil A X = X B. Solves for the relative pose of the
/// targets (SolveLinearHandEye(), robustly) and makes them one rigid target,
/// whose shared views connect the cameras; repeats this for the pair of groups
/// that the motion determines best until all are connected, or no pair with
/// kMinMotionFrames common frames is left. Boards that move relative to each
/// other are not joined.
/// @param groups   camera indices of each group, in the order of `names`
/// @param adjusted adjustment of each group, with independent boards
/// @param pairs    boards whose relative poses were compared
/// Throws Error(kInitializationFailed) if the motion does not determine the
/// relative pose, with the motion that is missing, or if no relative pose fits.
void ConnectByMotion(const std::vector<std::string>& names,
                     const std::vector<std::vector<int>>& groups,
                     const std::vector<AdjustmentResult>& adjusted,
                     const Pattern& pattern,
                     const std::vector<BoardPair>& pairs,
                     RigidTargets* rigid_targets);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RIG_MOTION_H
