/// The base of the fisheye models: equidistant coordinates of a point,
///   (u, v) = theta (x, y) / rho,  rho = |(x, y)|,  theta = atan2(rho, z),
/// which are smooth except straight backwards, and a distortion of them:
///   u' = u g(theta) + 2 p1 u v + p2 (theta^2 + 2 u^2) + sx1 theta^2
///   v' = v g(theta) + p1 (theta^2 + 2 v^2) + 2 p2 u v + sy1 theta^2
///   pixel = (fx u' + cx, fy v' + cy)
#ifndef RAYGRID_CAMERA_EQUIDISTANT_H
#define RAYGRID_CAMERA_EQUIDISTANT_H

#include <ceres/jet.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <optional>

namespace raygrid {

/// Angle at which models end: (u, v) is not unique near straight backwards.
constexpr double kMaxTheta = 3.1;

template <typename T>
Eigen::Matrix<T, 2, 1> ToEquidistant(const Eigen::Matrix<T, 3, 1>& point) {
  using std::atan2;
  using std::sqrt;
  const T rho2 = point.x() * point.x() + point.y() * point.y();
  T scale;  // theta / rho
  if (point.z() > 0.0 && rho2 < 1e-8 * point.z() * point.z()) {
    const T q = rho2 / (point.z() * point.z());
    scale = (1.0 - q * (1.0 / 3 - q / 5.0)) / point.z();
  } else {
    const T rho = sqrt(rho2);
    scale = atan2(rho, point.z()) / rho;
  }
  return {scale * point.x(), scale * point.y()};
}

/// Returns the unit direction of equidistant coordinates.
inline Eigen::Vector3d FromEquidistant(const Eigen::Vector2d& uv) {
  const double theta = uv.norm();
  const double scale = theta > 1e-9 ? std::sin(theta) / theta : 1;
  return Eigen::Vector3d(scale * uv.x(), scale * uv.y(), std::cos(theta))
      .normalized();
}

/// Returns a direction with the given equidistant coordinates, also for jets:
/// x, y = (u, v), and z such that theta = atan2(|(u, v)|, z).
template <typename T>
Eigen::Matrix<T, 3, 1> DirectionAt(const Eigen::Matrix<T, 2, 1>& uv) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T theta2 = uv.squaredNorm();
  if (theta2 < 1e-8) {
    const T scale = 1.0 - theta2 / 6.0;
    return {scale * uv.x(), scale * uv.y(), 1.0 - theta2 / 2.0};
  }
  const T theta = sqrt(theta2);
  const T scale = sin(theta) / theta;
  return {scale * uv.x(), scale * uv.y(), cos(theta)};
}

/// fx fy cx cy p1 p2 sx1 sy1.
template <typename T>
struct PlanarDistortion {
  T fx, fy, cx, cy, p1, p2, sx1, sy1;

  /// Returns the pixel of (u, v) for a radial factor g.
  Eigen::Matrix<T, 2, 1> ToPixel(const Eigen::Matrix<T, 2, 1>& uv,
                                 const T& g) const {
    const T &u = uv.x(), &v = uv.y();
    const T t2 = u * u + v * v;
    const T u_distorted =
        u * g + 2.0 * p1 * u * v + p2 * (t2 + 2.0 * u * u) + sx1 * t2;
    const T v_distorted =
        v * g + p1 * (t2 + 2.0 * v * v) + 2.0 * p2 * u * v + sy1 * t2;
    return {fx * u_distorted + cx, fy * v_distorted + cy};
  }
};

/// Returns the angle, at most `limit`, up to which theta g(theta) increases.
template <typename RadialFactor>
double FindMaxTheta(const RadialFactor& g, double limit) {
  constexpr double kStep = 0.005;
  double previous = 0, theta = 0;
  while (theta < limit) {
    const double next = std::min(theta + kStep, limit);
    const double radius = next * g(next);
    if (!(radius > previous)) return theta;
    previous = radius;
    theta = next;
  }
  return limit;
}

/// Finds the (u, v), of at most length max_theta, of a pixel by Newton's method
/// from `start`. `distort` maps (u, v) to pixels, in jets.
template <typename Distort>
std::optional<Eigen::Vector2d> InvertDistortion(const Distort& distort,
                                                const Eigen::Vector2d& pixel,
                                                const Eigen::Vector2d& start,
                                                double max_theta) {
  using Jet = ceres::Jet<double, 2>;
  constexpr double kConvergedPx = 1e-10, kGoodPx = 1e-7;
  Eigen::Vector2d at = start;
  if (at.norm() > 0.95 * max_theta) at *= 0.95 * max_theta / at.norm();
  for (int iteration = 0; iteration < 60; ++iteration) {
    const Eigen::Matrix<Jet, 2, 1> value =
        distort(Eigen::Matrix<Jet, 2, 1>(Jet(at.x(), 0), Jet(at.y(), 1)));
    Eigen::Matrix2d derivative;
    derivative << value[0].v.transpose(), value[1].v.transpose();
    const Eigen::Vector2d error =
        pixel - Eigen::Vector2d(value[0].a, value[1].a);
    if (error.norm() < kConvergedPx) return at;
    Eigen::Vector2d step = derivative.inverse() * error;
    if (!step.allFinite()) return std::nullopt;
    // Stay where the model is invertible.
    while ((at + step).norm() > max_theta && step.norm() > 1e-12) step /= 2;
    at += step;
    if (step.norm() < 1e-15)
      return error.norm() < kGoodPx ? std::optional(at) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_EQUIDISTANT_H
