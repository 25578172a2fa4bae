#include "calibration/bodies.h"

#include <map>

namespace raygrid {
namespace {

bool IsApart(const Bodies& bodies, const CalibrationProblem& problem,
             size_t view) {
  return bodies.apart.count({problem.images[view], problem.boards[view]}) > 0;
}

// The frame of each board, of which something is seen where the body is.
std::vector<int> SeenFrames(const Bodies& bodies,
                            const CalibrationProblem& problem) {
  std::vector<bool> is_seen(bodies.frames.size());
  for (size_t v = 0; v < problem.views.size(); ++v)
    if (!IsApart(bodies, problem, v)) is_seen[problem.boards[v]] = true;
  std::vector<int> frames = bodies.frames;
  for (size_t b = 0; b < frames.size(); ++b) {
    const int frame = bodies.frames[b];
    if (is_seen[frame]) continue;
    for (size_t other = 0; other < frames.size(); ++other) {
      if (bodies.frames[other] != frame || !is_seen[other]) continue;
      frames[b] = static_cast<int>(other);
      break;
    }
  }
  return frames;
}

}  // namespace

std::vector<std::vector<int>> Bodies::Groups() const {
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

Bodies BodiesOf(const Pattern& pattern) {
  Bodies bodies;
  if (pattern.bodies.empty()) return bodies;
  std::map<int, int> index_of;
  for (const Board& board : pattern.boards) {
    const int index = static_cast<int>(index_of.size());
    index_of[board.id] = index;
    bodies.frames.push_back(index);
  }
  bodies.frame_from_board.resize(pattern.boards.size());
  for (const BoardBody& body : pattern.bodies)
    for (size_t i = 0; i < body.boards.size(); ++i) {
      const int board = index_of.at(body.boards[i]);
      bodies.frames[board] = index_of.at(body.boards.front());
      bodies.frame_from_board[board] =
          body.first_from_board.front().Inverse() * body.first_from_board[i];
    }
  return bodies;
}

void JoinBoards(const Bodies& bodies, CalibrationProblem* problem,
                std::vector<Pose>* body_from_board) {
  body_from_board->clear();
  if (bodies.empty()) return;
  problem->frames = SeenFrames(bodies, *problem);
  problem->places.assign(problem->frames.size(), -1);
  for (size_t b = 0; b < problem->frames.size(); ++b) {
    const int frame = problem->frames[b];
    if (frame == static_cast<int>(b)) continue;
    problem->places[b] = static_cast<int>(body_from_board->size());
    body_from_board->push_back(bodies.frame_from_board[frame].Inverse() *
                               bodies.frame_from_board[b]);
  }
  // An instant, the board whose frame stands at the pose, whether alone.
  std::map<std::pair<std::string, std::pair<int, bool>>, int> pose_of;
  for (size_t v = 0; v < problem->views.size(); ++v) {
    View& view = problem->views[v];
    const int board = problem->boards[v];
    const bool is_apart = IsApart(bodies, *problem, v);
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

Bodies AdjustedBodies(const Bodies& bodies, const CalibrationProblem& problem,
                      const std::vector<Pose>& body_from_board) {
  Bodies adjusted = bodies;
  for (size_t b = 0; b < bodies.frames.size(); ++b) {
    adjusted.frames[b] = problem.frames[b];
    const int place = problem.places[b];
    adjusted.frame_from_board[b] = place < 0 ? Pose() : body_from_board[place];
  }
  return adjusted;
}

}  // namespace raygrid
