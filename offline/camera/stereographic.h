/// Stereographic coordinates of directions: the chart of the central model's
/// spline. (a, b) = tan(theta / 2) (cos phi, sin phi), with theta the angle
/// from the z axis: smooth except straight backwards, and conformal, so that a
/// displacement has the same scale in all directions.
#ifndef RAYGRID_CAMERA_STEREOGRAPHIC_H
#define RAYGRID_CAMERA_STEREOGRAPHIC_H

#include <Eigen/Core>

namespace raygrid {

/// Returns the chart coordinates of a direction of any length, not backwards.
inline Eigen::Vector2d ToChart(const Eigen::Vector3d& direction) {
  return direction.head<2>() / (direction.norm() + direction.z());
}

/// Returns the derivative of ToChart() with respect to the direction.
inline Eigen::Matrix<double, 2, 3> ToChartDerivative(
    const Eigen::Vector3d& direction) {
  const double norm = direction.norm();
  const double d = norm + direction.z();
  const Eigen::RowVector3d d_derivative =
      direction.transpose() / norm + Eigen::RowVector3d(0, 0, 1);
  Eigen::Matrix<double, 2, 3> derivative =
      -direction.head<2>() / (d * d) * d_derivative;
  derivative(0, 0) += 1 / d;
  derivative(1, 1) += 1 / d;
  return derivative;
}

/// Returns the unit direction of chart coordinates.
inline Eigen::Vector3d FromChart(const Eigen::Vector2d& chart) {
  const double s = chart.squaredNorm();
  return Eigen::Vector3d(2 * chart.x(), 2 * chart.y(), 1 - s) / (1 + s);
}

/// Returns the derivative of a direction's chart coordinates with respect to a
/// rotation vector; columns for rotations about x, y, z.
inline Eigen::Matrix<double, 2, 3> ChartRotationDerivative(
    const Eigen::Vector2d& chart) {
  const Eigen::Vector3d d = FromChart(chart);
  Eigen::Matrix3d minus_cross;  // omega x d = -[d]x omega
  minus_cross << 0, d.z(), -d.y(), -d.z(), 0, d.x(), d.y(), -d.x(), 0;
  return ToChartDerivative(d) * minus_cross;
}

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_STEREOGRAPHIC_H
