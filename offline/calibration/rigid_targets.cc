#include "calibration/rigid_targets.h"

#include <map>

namespace raygrid {
namespace {

bool IsApart(const RigidTargets& rigid_targets,
             const CalibrationProblem& problem, size_t view) {
  return rigid_targets.apart.count(
             {problem.images[view], problem.boards[view]}) > 0;
}

// Returns the board that defines the frame of each board's target: one that is
// observed at its rigid position.
std::vector<int> FindReferenceBoards(const RigidTargets& rigid_targets,
                                     const CalibrationProblem& problem) {
  std::vector<bool> is_seen(rigid_targets.frames.size());
  for (size_t v = 0; v < problem.views.size(); ++v)
    if (!IsApart(rigid_targets, problem, v)) is_seen[problem.boards[v]] = true;
  std::vector<int> frames = rigid_targets.frames;
  for (size_t b = 0; b < frames.size(); ++b) {
    const int frame = rigid_targets.frames[b];
    if (is_seen[frame]) continue;
    for (size_t other = 0; other < frames.size(); ++other) {
      if (rigid_targets.frames[other] != frame || !is_seen[other]) continue;
      frames[b] = static_cast<int>(other);
      break;
    }
  }
  return frames;
}

}  // namespace

std::vector<std::vector<int>> RigidTargets::Groups() const {
  std::vector<std::vector<int>> groups;
  for (size_t frame = 0; frame < frames.size(); ++frame) {
    std::vector<int> group;
    for (size_t b = 0; b < frames.size(); ++b)
      if (frames[b] == static_cast<int>(frame))
        group.push_back(static_cast<int>(b));
    if (group.size() > 1) groups.push_back(std::move(group));
  }
  return groups;
}

RigidTargets MakeRigidTargets(const Pattern& pattern) {
  RigidTargets rigid_targets;
  if (pattern.rigid_targets.empty()) return rigid_targets;
  std::map<int, int> index_of;
  for (const Board& board : pattern.boards) {
    const int index = static_cast<int>(index_of.size());
    index_of[board.id] = index;
    rigid_targets.frames.push_back(index);
  }
  rigid_targets.frame_from_board.resize(pattern.boards.size());
  for (const RigidTarget& body : pattern.rigid_targets)
    for (size_t i = 0; i < body.boards.size(); ++i) {
      const int board = index_of.at(body.boards[i]);
      rigid_targets.frames[board] = index_of.at(body.boards.front());
      rigid_targets.frame_from_board[board] =
          body.first_from_board.front().Inverse() * body.first_from_board[i];
    }
  return rigid_targets;
}

RigidTargets SeparateTargets(size_t num_boards) {
  RigidTargets rigid_targets;
  for (size_t b = 0; b < num_boards; ++b)
    rigid_targets.frames.push_back(static_cast<int>(b));
  rigid_targets.frame_from_board.resize(num_boards);
  return rigid_targets;
}

void UniteTargets(int first, int second, const Pose& first_from_second,
                  RigidTargets* rigid_targets) {
  const int kept = rigid_targets->frames[first];
  const int joined = rigid_targets->frames[second];
  if (kept == joined) return;
  const Pose kept_from_joined =
      rigid_targets->frame_from_board[first] * first_from_second *
      rigid_targets->frame_from_board[second].Inverse();
  for (size_t b = 0; b < rigid_targets->frames.size(); ++b) {
    if (rigid_targets->frames[b] != joined) continue;
    rigid_targets->frames[b] = kept;
    rigid_targets->frame_from_board[b] =
        kept_from_joined * rigid_targets->frame_from_board[b];
  }
}

void JoinBoards(const RigidTargets& rigid_targets, CalibrationProblem* problem,
                std::vector<Pose>* target_from_board) {
  target_from_board->clear();
  if (rigid_targets.empty()) return;
  problem->frames = FindReferenceBoards(rigid_targets, *problem);
  problem->places.assign(problem->frames.size(), -1);
  for (size_t b = 0; b < problem->frames.size(); ++b) {
    const int frame = problem->frames[b];
    if (frame == static_cast<int>(b)) continue;
    problem->places[b] = static_cast<int>(target_from_board->size());
    target_from_board->push_back(
        rigid_targets.frame_from_board[frame].Inverse() *
        rigid_targets.frame_from_board[b]);
  }
  // Key: frame, board that defines the pose, and whether the board is
  // separated.
  std::map<std::pair<std::string, std::pair<int, bool>>, int> pose_of;
  for (size_t v = 0; v < problem->views.size(); ++v) {
    View& view = problem->views[v];
    const int board = problem->boards[v];
    const bool is_apart = IsApart(rigid_targets, *problem, v);
    view.place = is_apart ? -1 : problem->places[board];
    const int frame = is_apart ? board : problem->frames[board];
    view.pose =
        pose_of
            .emplace(std::pair(problem->images[v], std::pair(frame, is_apart)),
                     pose_of.size())
            .first->second;
  }
  problem->num_poses = static_cast<int>(pose_of.size());
}

RigidTargets UpdateRigidTargets(const RigidTargets& rigid_targets,
                                const CalibrationProblem& problem,
                                const std::vector<Pose>& target_from_board) {
  RigidTargets adjusted = rigid_targets;
  for (size_t b = 0; b < rigid_targets.frames.size(); ++b) {
    adjusted.frames[b] = problem.frames[b];
    const int place = problem.places[b];
    adjusted.frame_from_board[b] =
        place < 0 ? Pose() : target_from_board[place];
  }
  return adjusted;
}

}  // namespace raygrid
