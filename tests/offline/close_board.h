#ifndef RAYGRID_TESTS_OFFLINE_CLOSE_BOARD_H
#define RAYGRID_TESTS_OFFLINE_CLOSE_BOARD_H

#include <Eigen/Geometry>
#include <optional>

#include "camera/camera_model.h"
#include "camera/pose.h"
#include "features/board_view/feature_lattice.h"

namespace raygrid {

/// The image that a close board fills most of.
constexpr ImageSize kCloseViewSize = {1280, 800};

/// A board of 16 x 12 stars, squares of 1 m.
inline Board StarsOfOneMetre() {
  Board board;
  board.kind = "star";
  board.columns = 16;
  board.rows = 12;
  board.square_m = 1;
  return board;
}

/// That board tilted, at a distance in squares: it fills most of the view of a
/// pinhole at 14, of a lens of 190 degrees at 4.
inline Pose CloseBoard(double distance) {
  return {Eigen::Quaterniond(
              Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 0.5, 0).normalized())),
          Eigen::Vector3d(-7.5, -5.5, distance)};
}

/// The pixel of a place on the board, in squares, if it is in the image.
inline std::optional<Eigen::Vector2d> SeenAt(const CameraModel& camera,
                                             const Pose& pose,
                                             const Eigen::Vector2d& place) {
  const auto pixel =
      camera.Project(pose * Eigen::Vector3d(place.x(), place.y(), 0));
  return pixel && camera.area().Contains(*pixel) ? pixel : std::nullopt;
}

/// All stars in the image. Keeps a reference to the board.
inline FeatureLattice SeenLattice(const CameraModel& camera, const Pose& pose,
                                  const Board& board) {
  FeatureLattice lattice(board);
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      if (const auto pixel = SeenAt(camera, pose, Eigen::Vector2d(column, row)))
        lattice.Set(column, row, *pixel);
  return lattice;
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_CLOSE_BOARD_H
