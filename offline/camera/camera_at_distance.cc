#include "camera/camera_at_distance.h"

#include <cmath>

namespace raygrid {

std::optional<Eigen::Vector3d> CameraAtDistance::Unproject(
    const Eigen::Vector2d& pixel) const {
  const auto line = lines_->Line(pixel);
  if (!line) return std::nullopt;
  // The far one of the points where the line meets the sphere.
  const double along = line->direction.dot(line->origin);
  const double square =
      along * along - line->origin.squaredNorm() + distance_m_ * distance_m_;
  if (!(square >= 0)) return std::nullopt;
  const double t = std::sqrt(square) - along;
  return (line->origin + t * line->direction).normalized();
}

std::optional<Eigen::Vector2d> CameraAtDistance::Project(
    const Eigen::Vector3d& direction, const Eigen::Vector2d* start,
    double margin_px) const {
  return lines_->Project(distance_m_ * direction.normalized(), start,
                         margin_px);
}

bool CameraAtDistance::Linearize(const Eigen::Vector3d& direction,
                                 const Eigen::Vector2d* start, double margin_px,
                                 LinearizedProjection* projection) const {
  const Eigen::Vector3d unit = direction.normalized();
  if (!lines_->Linearize(distance_m_ * unit, start, margin_px, projection))
    return false;
  const Eigen::Matrix3d by_direction =
      (Eigen::Matrix3d::Identity() - unit * unit.transpose()) *
      (distance_m_ / direction.norm());
  projection->by_point = (projection->by_point * by_direction).eval();
  projection->num_nodes = 0;
  projection->num_global = 0;
  return true;
}

}  // namespace raygrid
