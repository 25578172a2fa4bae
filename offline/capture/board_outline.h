#ifndef RAYGRID_CAPTURE_BOARD_OUTLINE_H
#define RAYGRID_CAPTURE_BOARD_OUTLINE_H

#include <Eigen/Core>
#include <vector>

#include "camera/camera_model.h"
#include "camera/pose.h"
#include "dataset/pattern.h"

namespace raygrid {

/// The steps of each side of an outline.
constexpr int kOutlineSteps = 8;

/// The outermost features' outline as a camera sees it, closed, in pixels:
/// kOutlineSteps points a side, along the first row first, then down the last
/// column. Where the camera does not tell, beyond its image, the homography
/// that is nearest to what it sees of the board goes on. Empty if it sees less
/// than four features.
std::vector<Eigen::Vector2d> OutlineOf(const CameraModel& camera,
                                       const Board& board,
                                       const Pose& camera_from_board);

/// The points of an outline on a board, in its own order.
std::vector<Eigen::Vector3d> OutlinePoints(const Board& board);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_BOARD_OUTLINE_H
