#include "calibration/continued_lens.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace raygrid {

ContinuedLens::ContinuedLens(const CameraModel& lens, const Area& area,
                             double max_angle_rad)
    : CameraModel(lens.image_size(), area),
      lens_(lens.Clone()),
      max_angle_rad_(max_angle_rad) {
  LinearizedProjection linear;
  if (!lens.Linearize({0, 0, 1}, nullptr, 0, &linear)) return;
  center_ = linear.pixel;
  focal_px_ = std::sqrt(std::abs(linear.by_point.leftCols<2>().determinant()));
}

Eigen::Vector3d ContinuedLens::Direction(double angle_rad,
                                         const Eigen::Vector2d& side) {
  const Eigen::Vector2d across = std::sin(angle_rad) * side.normalized();
  return {across.x(), across.y(), std::cos(angle_rad)};
}

std::optional<Eigen::Vector3d> ContinuedLens::Unproject(
    const Eigen::Vector2d& pixel) const {
  constexpr double kStep = 0.02, kMinPart = 0.9, kAnywherePx = 1e9,
                   kLargest = 2.3;
  if (!area().Contains(pixel)) return std::nullopt;
  const auto ray = lens_->Unproject(pixel);
  if (ray && std::atan2(ray->head<2>().norm(), ray->z()) <= max_angle_rad_)
    return ray;
  if (!(focal_px_ > 0)) return ray;
  // From where the lens ends on this side; if it ends long before, it is not
  // known how it goes on.
  const Eigen::Vector2d side = pixel - center_;
  double angle = max_angle_rad_;
  std::optional<Eigen::Vector2d> edge;
  for (; angle > kMinPart * max_angle_rad_; angle -= kStep) {
    edge = lens_->Project(Direction(angle, side), nullptr, kAnywherePx);
    if (edge) break;
  }
  if (!edge) return std::nullopt;
  const double beyond_px = side.norm() - (*edge - center_).norm();
  if (beyond_px < 0) return std::nullopt;
  return Direction(std::min(angle + beyond_px / focal_px_, kLargest), side);
}

}  // namespace raygrid
