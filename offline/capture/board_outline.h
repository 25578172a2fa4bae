#ifndef RAYGRID_CAPTURE_BOARD_OUTLINE_H
#define RAYGRID_CAPTURE_BOARD_OUTLINE_H

#include <Eigen/Core>
#include <vector>

#include "camera/camera_model.h"
#include "camera/pose.h"
#include "dataset/pattern.h"

namespace raygrid {

/// Number of steps per side of an outline.
constexpr int kOutlineSteps = 8;

/// Projects the closed outline of the outermost features to the image, in
/// pixels: kOutlineSteps points per side, first along the first row, then down
/// the last column. Outside the image, the projection is extrapolated by the
/// homography that best fits the visible features. Empty if fewer than four
/// features are visible.
std::vector<Eigen::Vector2d> ProjectOutline(const CameraModel& camera,
                                            const Board& board,
                                            const Pose& camera_from_board);

/// Returns the points of an outline in the board frame, in the same order.
std::vector<Eigen::Vector3d> OutlinePoints(const Board& board);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_BOARD_OUTLINE_H
