#include "capture/board_view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

// Returns the angular resolution in pixels per radian at a pixel along an image
// axis; 0 if the camera is undefined there.
double PixelsPerRadian(const CameraModel& camera, const Eigen::Vector2d& pixel,
                       const Eigen::Vector2d& axis) {
  const Area& area = camera.area();
  const auto inside = [&area](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(std::clamp(p.x(), area.x0, area.x1),
                           std::clamp(p.y(), area.y0, area.y1));
  };
  const Eigen::Vector2d from = inside(pixel - axis), to = inside(pixel + axis);
  const auto first = camera.Line(from), second = camera.Line(to);
  if (!first || !second) return 0;
  const double sine = first->direction.cross(second->direction).norm();
  return sine > 0 ? (to - from).norm() / std::asin(std::min(1.0, sine)) : 0;
}

}  // namespace

Eigen::Vector3d ComputeBoardCenter(const Board& board) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const std::vector<Eigen::Vector3d> points = board.NominalPoints();
  for (const Eigen::Vector3d& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

std::optional<Pose> ComputePose(const BoardView& view, const Board& board,
                                const CameraModel& camera) {
  const auto line = camera.Line(view.pixel);
  if (!line || !camera.IsInImageCircle(view.pixel)) return std::nullopt;
  const double scale =
      std::sqrt(PixelsPerRadian(camera, view.pixel, Eigen::Vector2d::UnitX()) *
                PixelsPerRadian(camera, view.pixel, Eigen::Vector2d::UnitY()));
  if (!(scale > 0) || !(view.width_px > 0)) return std::nullopt;
  const std::vector<Eigen::Vector3d> points = board.NominalPoints();
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : points) box.extend(point);
  const double distance_m = box.sizes().maxCoeff() * scale / view.width_px;
  const Eigen::Quaterniond facing = Eigen::Quaterniond::FromTwoVectors(
      Eigen::Vector3d::UnitZ(), line->direction);
  const Eigen::AngleAxisd tilt(
      view.tilt_rad,
      Eigen::Vector3d(std::cos(view.axis_rad), std::sin(view.axis_rad), 0));
  const Eigen::AngleAxisd turn(view.turn_rad, Eigen::Vector3d::UnitZ());
  const Eigen::Quaterniond rotation = facing * tilt * turn;
  return Pose{rotation, line->origin + line->direction * distance_m -
                            rotation * ComputeBoardCenter(board)};
}

}  // namespace raygrid
