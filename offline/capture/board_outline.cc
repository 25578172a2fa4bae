#include "capture/board_outline.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <optional>

namespace raygrid {
namespace {

// Homography from the board plane to pixels, fitted to the visible part, and
// the sign of the homogeneous coordinate on the board's side of the plane at
// infinity.
struct BoardHomography {
  Eigen::Matrix3d pixel_from_board;
  double sign = 1;

  Eigen::Vector2d operator*(const Eigen::Vector3d& point) const {
    Eigen::Vector3d pixel =
        pixel_from_board * Eigen::Vector3d(point.x(), point.y(), 1);
    // Clamps the depth: points in the principal plane would project to
    // infinity.
    const double least = 1e-3 * pixel_from_board.row(2).norm();
    pixel.z() = std::max(sign * pixel.z(), least) * sign;
    return pixel.hnormalized();
  }
};

// Direct linear transform; nullopt for fewer than four features.
std::optional<BoardHomography> FitHomography(const CameraModel& camera,
                                             const Board& board,
                                             const Pose& camera_from_board) {
  // Normalizes coordinates to about 1 for numerical conditioning.
  const double pixels = camera.image_size().width;
  const double metres = std::max(board.columns, board.rows) * board.square_m;
  Eigen::Matrix<double, 9, 9> square = Eigen::Matrix<double, 9, 9>::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int num_visible = 0;
  for (const Eigen::Vector3d& point : board.points) {
    const auto pixel = camera.Project(camera_from_board * point);
    if (!pixel) continue;
    const Eigen::Vector3d from(point.x() / metres, point.y() / metres, 1);
    const Eigen::Vector2d to = *pixel / pixels;
    Eigen::Matrix<double, 2, 9> rows;
    rows << from.transpose(), Eigen::RowVector3d::Zero(),
        -to.x() * from.transpose(),  //
        Eigen::RowVector3d::Zero(), from.transpose(),
        -to.y() * from.transpose();
    square += rows.transpose() * rows;
    sum += from;
    ++num_visible;
  }
  constexpr int kMinCorners = 4;
  if (num_visible < kMinCorners) return std::nullopt;
  const Eigen::Matrix<double, 9, 1> least =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>>(square)
          .eigenvectors()
          .col(0);
  Eigen::Matrix3d scaled;
  scaled << least.segment<3>(0).transpose(), least.segment<3>(3).transpose(),
      least.segment<3>(6).transpose();
  BoardHomography homography;
  homography.sign = scaled.row(2).dot(sum) < 0 ? -1 : 1;
  homography.pixel_from_board =
      Eigen::Vector3d(pixels, pixels, 1).asDiagonal() * scaled *
      Eigen::Vector3d(1 / metres, 1 / metres, 1).asDiagonal();
  return homography;
}

}  // namespace

std::vector<Eigen::Vector3d> OutlinePoints(const Board& board) {
  const auto at = [&board](int column, int row) -> const Eigen::Vector3d& {
    return board.points[board.PointIndex(column, row)];
  };
  const int right = board.columns - 1, low = board.rows - 1;
  const Eigen::Vector3d corners[] = {at(0, 0), at(right, 0), at(right, low),
                                     at(0, low), at(0, 0)};
  std::vector<Eigen::Vector3d> points;
  for (int side = 0; side < 4; ++side)
    for (int k = 0; k < kOutlineSteps; ++k)
      points.push_back(corners[side] + k * (corners[side + 1] - corners[side]) /
                                           double(kOutlineSteps));
  return points;
}

std::vector<Eigen::Vector2d> ProjectOutline(const CameraModel& camera,
                                            const Board& board,
                                            const Pose& camera_from_board) {
  const auto homography = FitHomography(camera, board, camera_from_board);
  std::vector<Eigen::Vector2d> outline;
  if (!homography) return outline;
  for (const Eigen::Vector3d& point : OutlinePoints(board)) {
    const auto pixel = camera.Project(camera_from_board * point);
    outline.push_back(pixel ? *pixel : *homography * point);
  }
  return outline;
}

}  // namespace raygrid
