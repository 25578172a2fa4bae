#ifndef RAYGRID_CAPTURE_VIEW_HINT_H
#define RAYGRID_CAPTURE_VIEW_HINT_H

#include <string>

#include "camera/camera_model.h"
#include "camera/pose.h"
#include "dataset/pattern.h"

namespace raygrid {

/// How a board is to be moved from one pose, camera_from_board, to another, in
/// words for who sees the picture: "closer, tilt the top away". At most three
/// moves, the largest first; "hold it there" where none is worth a word.
std::string DescribeMove(const CameraModel& camera, const Board& board,
                         const Pose& from, const Pose& to);

/// Whether no move from one pose to another is worth a word.
bool IsThere(const CameraModel& camera, const Board& board, const Pose& from,
             const Pose& to);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_VIEW_HINT_H
