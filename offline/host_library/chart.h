/// camera/stereographic.h in Scalar precision, with derivatives for Jacobians.
#ifndef RAYGRID_HOST_LIBRARY_CHART_H
#define RAYGRID_HOST_LIBRARY_CHART_H

#include <Eigen/Core>
#include <cmath>

namespace raygrid::host {

template <typename Scalar>
using Vec2 = Eigen::Matrix<Scalar, 2, 1>;
template <typename Scalar>
using Vec3 = Eigen::Matrix<Scalar, 3, 1>;
template <typename Scalar>
using Mat22 = Eigen::Matrix<Scalar, 2, 2>;
template <typename Scalar>
using Mat23 = Eigen::Matrix<Scalar, 2, 3>;
template <typename Scalar>
using Mat32 = Eigen::Matrix<Scalar, 3, 2>;

/// Not finite for zero and straight backwards.
template <typename Scalar>
Vec2<Scalar> ToChart(const Vec3<Scalar>& v) {
  const Scalar rho2 = v.x() * v.x() + v.y() * v.y();
  const Scalar norm = std::sqrt(rho2 + v.z() * v.z());
  // norm + z cancels for directions behind the camera.
  const Scalar scale = v.z() >= 0 ? 1 / (norm + v.z()) : (norm - v.z()) / rho2;
  return {scale * v.x(), scale * v.y()};
}

/// Returns the chart coordinates, and d chart / d v.
template <typename Scalar>
Vec2<Scalar> ToChart(const Vec3<Scalar>& v, Mat23<Scalar>* J) {
  const Scalar rho2 = v.x() * v.x() + v.y() * v.y();
  const Scalar norm = std::sqrt(rho2 + v.z() * v.z());
  const Scalar scale = v.z() >= 0 ? 1 / (norm + v.z()) : (norm - v.z()) / rho2;
  const Scalar a = scale * v.x(), b = scale * v.y();
  // d scale / d v = -scale (v / norm + (0, 0, 1)) scale
  const Scalar k = scale / norm;
  const Scalar x = k * v.x(), y = k * v.y(), z = k * v.z() + scale;
  *J << scale - a * x, -a * y, -a * z, -b * x, scale - b * y, -b * z;
  return {a, b};
}

template <typename Scalar>
Vec3<Scalar> FromChart(const Vec2<Scalar>& chart) {
  const Scalar s = chart.x() * chart.x() + chart.y() * chart.y();
  const Scalar k = 2 / (1 + s);
  return {k * chart.x(), k * chart.y(), k * ((1 - s) / 2)};
}

/// d direction / d chart.
template <typename Scalar>
Mat32<Scalar> FromChartJacobian(const Vec2<Scalar>& chart) {
  const Scalar a = chart.x(), b = chart.y();
  const Scalar k = 2 / (1 + a * a + b * b), k2 = k * k;
  Mat32<Scalar> J;
  J << k - k2 * a * a, -k2 * a * b, -k2 * a * b, k - k2 * b * b, -k2 * a,
      -k2 * b;
  return J;
}

/// Solves J x = b for a 2 x 2 matrix.
template <typename Scalar>
Vec2<Scalar> Solve(const Mat22<Scalar>& J, const Vec2<Scalar>& b,
                   Scalar determinant) {
  const Scalar r = 1 / determinant;
  return {r * (J(1, 1) * b.x() - J(0, 1) * b.y()),
          r * (J(0, 0) * b.y() - J(1, 0) * b.x())};
}

}  // namespace raygrid::host

#endif  // RAYGRID_HOST_LIBRARY_CHART_H
