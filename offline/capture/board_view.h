#ifndef RAYGRID_CAPTURE_BOARD_VIEW_H
#define RAYGRID_CAPTURE_BOARD_VIEW_H

#include <Eigen/Core>
#include <optional>

#include "camera/camera_model.h"
#include "camera/pose.h"
#include "dataset/pattern.h"

namespace raygrid {

/// How a board is held before a camera.
struct BoardView {
  Eigen::Vector2d pixel;  ///< where the board's middle is seen
  double width_px = 0;    ///< of its longer side there, if it were not tilted
  /// From facing the camera, around an axis across the line of sight, whose
  /// angle from the image's x axis is axis_rad.
  double tilt_rad = 0, axis_rad = 0;
  double turn_rad = 0;  ///< in its own plane
};

/// The middle of a board's nominal points.
Eigen::Vector3d MiddleOf(const Board& board);

/// camera_from_board; nothing where the camera sees nothing.
std::optional<Pose> PoseOf(const BoardView& view, const Board& board,
                           const CameraModel& camera);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_BOARD_VIEW_H
