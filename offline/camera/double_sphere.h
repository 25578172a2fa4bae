#ifndef RAYGRID_CAMERA_DOUBLE_SPHERE_H
#define RAYGRID_CAMERA_DOUBLE_SPHERE_H

#include "camera/formula_model.h"

namespace raygrid {

/// The double sphere model (V. Usenko, N. Demmel, D. Cremers, 3DV 2018), as in
/// Kalibr and basalt:
///   d1 = |point|,  z' = xi d1 + point.z,  d2 = |(point.x, point.y, z')|
///   (x, y) = point.xy / (alpha d2 + (1 - alpha) z')
///   pixel = (fx x + cx, fy y + cy)
struct DoubleSphereFormula {
  enum { kFx, kFy, kCx, kCy, kXi, kAlpha, kCount };
  static constexpr const char* kName = models::kDoubleSphere;
  static constexpr double kMaxAngleOfIncidenceRad = kMaxTheta;

  static const std::vector<std::string>& Names() {
    static const std::vector<std::string> names = {"fx", "fy", "cx",
                                                   "cy", "xi", "alpha"};
    return names;
  }

  template <typename T>
  static Eigen::Matrix<T, 2, 1> Pixel(const Eigen::Matrix<T, 3, 1>& point,
                                      const T* p) {
    using std::sqrt;
    const T &x = point.x(), &y = point.y();
    const T z = p[kXi] * point.norm() + point.z();
    const T depth =
        p[kAlpha] * sqrt(x * x + y * y + z * z) + (1.0 - p[kAlpha]) * z;
    return {p[kFx] * x / depth + p[kCx], p[kFy] * y / depth + p[kCy]};
  }

  static double Radius(double theta, const double* p) {
    const double z = p[kXi] + std::cos(theta), rho = std::sin(theta);
    const double depth = p[kAlpha] * std::hypot(rho, z) + (1 - p[kAlpha]) * z;
    return depth > 0 ? rho / depth : NAN;
  }

  static std::vector<int> DistortionOrders() { return {0, 0, 0, 0, 3, 3}; }

  static std::vector<std::array<double, kCount>> InitialValues(double f,
                                                               double cx,
                                                               double cy) {
    return {{0.8 * f, 0.8 * f, cx, cy, -0.2, 0.6}};
  }
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_DOUBLE_SPHERE_H
