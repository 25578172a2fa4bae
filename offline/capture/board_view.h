#ifndef RAYGRID_CAPTURE_BOARD_VIEW_H
#define RAYGRID_CAPTURE_BOARD_VIEW_H

#include <Eigen/Core>
#include <optional>

#include "camera/camera_model.h"
#include "camera/pose.h"
#include "dataset/pattern.h"

namespace raygrid {

/// The position and orientation of a board relative to a camera.
struct BoardView {
  Eigen::Vector2d pixel;  ///< position of the board's centre
  double width_px = 0;    ///< length of its longer side, without tilt
  /// Tilt from facing the camera, about an axis perpendicular to the line of
  /// sight, at axis_rad from the image's x axis.
  double tilt_rad = 0, axis_rad = 0;
  double turn_rad = 0;  ///< rotation in its own plane
};

/// Returns the centre of a board's nominal points.
Eigen::Vector3d ComputeBoardCenter(const Board& board);

/// Returns camera_from_board; nullopt if the camera has no ray at the pixel.
std::optional<Pose> ComputePose(const BoardView& view, const Board& board,
                                const CameraModel& camera);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_BOARD_VIEW_H
