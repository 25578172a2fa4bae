#include "simulation/simulated_fisheye.h"

#include <cmath>

namespace raygrid {

std::optional<Eigen::Vector3d> SimulatedFisheye::Unproject(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  const Eigen::Vector2d offset =
      pixel - Eigen::Vector2d(parameters_.cx, parameters_.cy);
  const double radius = offset.norm();
  if (radius > parameters_.Radius(parameters_.max_theta)) return std::nullopt;
  double theta = std::min(radius / parameters_.f_px, parameters_.max_theta);
  for (int iteration = 0; iteration < 50; ++iteration) {
    const double step = (radius - parameters_.Radius(theta)) /
                        parameters_.RadiusDerivative(theta);
    theta += step;
    if (std::abs(step) < 1e-15) break;
  }
  // sin(theta) / radius, with its limit at the centre.
  const double scale =
      radius > 1e-9 ? std::sin(theta) / radius : 1 / parameters_.f_px;
  return Eigen::Vector3d(offset.x() * scale, offset.y() * scale,
                         std::cos(theta))
      .normalized();
}

std::optional<Eigen::Vector2d> SimulatedFisheye::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* /*start*/,
    double margin_px) const {
  const double across = point.head<2>().norm();
  const double theta = std::atan2(across, point.z());
  if (!(theta <= parameters_.max_theta) || point.isZero()) return std::nullopt;
  const double scale = across > 1e-12 * point.norm()
                           ? parameters_.Radius(theta) / across
                           : parameters_.f_px / point.z();
  const Eigen::Vector2d pixel(parameters_.cx + scale * point.x(),
                              parameters_.cy + scale * point.y());
  if (!area().Contains(pixel, margin_px)) return std::nullopt;
  return pixel;
}

bool SimulatedFisheye::Linearize(const Eigen::Vector3d& point,
                                 const Eigen::Vector2d* start, double margin_px,
                                 LinearizedProjection* projection) const {
  const auto pixel = Project(point, start, margin_px);
  if (!pixel) return false;
  projection->pixel = *pixel;
  const double across = point.head<2>().norm(), z = point.z();
  const double norm2 = point.squaredNorm();
  projection->J_point.setZero();
  if (across < 1e-12 * std::sqrt(norm2)) {
    projection->J_point(0, 0) = projection->J_point(1, 1) =
        parameters_.f_px / z;
    return true;
  }
  // pixel - center = r(theta) * unit, with unit = point.xy / across.
  const double theta = std::atan2(across, z);
  const double slope = parameters_.RadiusDerivative(theta);
  const Eigen::Vector2d unit = point.head<2>() / across;
  const Eigen::Matrix2d radial = unit * unit.transpose();
  projection->J_point.leftCols<2>() =
      slope * z / norm2 * radial + parameters_.Radius(theta) / across *
                                       (Eigen::Matrix2d::Identity() - radial);
  projection->J_point.col(2) = -slope * across / norm2 * unit;
  return true;
}

}  // namespace raygrid
