#ifndef RAYGRID_CALIBRATION_RIGID_TARGETS_H
#define RAYGRID_CALIBRATION_RIGID_TARGETS_H

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "calibration/calibration_problem.h"

namespace raygrid {

/// Rigid multi-board targets of a pattern, by board index. The frame of a
/// target is the frame of one of its boards.
struct RigidTargets {
  /// For each board, the board that defines its target's frame; itself for an
  /// independent board. Empty if all boards are independent.
  std::vector<int> frames;
  std::vector<Pose> frame_from_board;
  /// Images and boards in them whose pose deviates from their target's.
  std::set<std::pair<std::string, int>> apart;

  bool empty() const { return frames.empty(); }
  /// Returns the boards of each target with more than one board.
  std::vector<std::vector<int>> Groups() const;
};

/// Returns the rigid targets that a pattern defines.
RigidTargets MakeRigidTargets(const Pattern& pattern);

/// Returns independent boards, each with the frame of its own.
RigidTargets SeparateTargets(size_t num_boards);

/// Merges the rigid targets of two boards.
void UniteTargets(int first, int second, const Pose& first_from_second,
                  RigidTargets* rigid_targets);

/// Makes the boards of a rigid target share one pose per frame.
/// *target_from_board receives AdjustmentState::target_from_board. For each
/// target, a board that is observed defines the frame.
void JoinBoards(const RigidTargets& rigid_targets, CalibrationProblem* problem,
                std::vector<Pose>* target_from_board);

/// Returns the rigid targets with the relative poses of an adjustment.
RigidTargets UpdateRigidTargets(const RigidTargets& rigid_targets,
                                const CalibrationProblem& problem,
                                const std::vector<Pose>& target_from_board);

/// Converts a target pose to the pose of a view's board, and vice versa.
inline Pose ComputeBoardPose(const View& view, const Pose& from_target,
                             const std::vector<Pose>& target_from_board) {
  return view.place < 0 ? from_target
                        : from_target * target_from_board[view.place];
}
inline Pose ComputeTargetPose(const View& view, const Pose& from_board,
                              const std::vector<Pose>& target_from_board) {
  return view.place < 0 ? from_board
                        : from_board * target_from_board[view.place].Inverse();
}

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RIGID_TARGETS_H
