#ifndef RAYGRID_CALIBRATION_RIGID_TARGETS_H
#define RAYGRID_CALIBRATION_RIGID_TARGETS_H

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "calibration/calibration_problem.h"

namespace raygrid {

/// Which boards of a pattern are fixed to each other, by their indices. The
/// frame of a body is that of one of its boards.
struct RigidTargets {
  /// The board that is the frame of each board's body; a board alone is its own
  /// frame. Empty if all are alone.
  std::vector<int> frames;
  std::vector<Pose> frame_from_board;
  /// Images, and boards in them that stand elsewhere than on their bodies.
  std::set<std::pair<std::string, int>> apart;

  bool empty() const { return frames.empty(); }
  /// Boards per body of more than one.
  std::vector<std::vector<int>> Groups() const;
};

/// Those that a pattern tells of.
RigidTargets MakeRigidTargets(const Pattern& pattern);

/// Lets the boards of a body share its pose at each instant. Places are those
/// of the boards on it, for AdjustmentState::target_from_board. Of each body, a
/// board that is seen becomes the frame.
void JoinBoards(const RigidTargets& rigid_targets, CalibrationProblem* problem,
                std::vector<Pose>* target_from_board);

/// The bodies with the places that an adjustment found.
RigidTargets UpdateRigidTargets(const RigidTargets& rigid_targets,
                                const CalibrationProblem& problem,
                                const std::vector<Pose>& target_from_board);

/// The pose of a view's board by that of its body, and the other way.
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
