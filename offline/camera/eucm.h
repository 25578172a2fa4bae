#ifndef RAYGRID_CAMERA_EUCM_H
#define RAYGRID_CAMERA_EUCM_H

#include "camera/formula_model.h"

namespace raygrid {

/// The enhanced unified camera model (B. Khomutenko, G. Garcia, P. Martinet,
/// RA-L 2016), as in Kalibr, basalt and COLMAP:
///   d = sqrt(beta (point.x^2 + point.y^2) + point.z^2)
///   (x, y) = point.xy / (alpha d + (1 - alpha) point.z)
///   pixel = (fx x + cx, fy y + cy)
struct EucmFormula {
  enum { kFx, kFy, kCx, kCy, kAlpha, kBeta, kCount };
  static constexpr const char* kName = models::kEucm;
  static constexpr double kMaxAngleOfIncidenceRad = kMaxTheta;

  static const std::vector<std::string>& Names() {
    static const std::vector<std::string> names = {"fx", "fy",    "cx",
                                                   "cy", "alpha", "beta"};
    return names;
  }

  template <typename T>
  static Eigen::Matrix<T, 2, 1> Pixel(const Eigen::Matrix<T, 3, 1>& point,
                                      const T* p) {
    using std::sqrt;
    const T &x = point.x(), &y = point.y(), &z = point.z();
    const T depth = p[kAlpha] * sqrt(p[kBeta] * (x * x + y * y) + z * z) +
                    (1.0 - p[kAlpha]) * z;
    return {p[kFx] * x / depth + p[kCx], p[kFy] * y / depth + p[kCy]};
  }

  static double Radius(double theta, const double* p) {
    const double z = std::cos(theta), rho = std::sin(theta);
    const double depth = p[kAlpha] * std::sqrt(p[kBeta] * rho * rho + z * z) +
                         (1 - p[kAlpha]) * z;
    return depth > 0 ? rho / depth : NAN;
  }

  static std::vector<int> DistortionOrders() { return {0, 0, 0, 0, 3, 3}; }

  static std::vector<std::array<double, kCount>> InitialValues(double f,
                                                               double cx,
                                                               double cy) {
    return {{f, f, cx, cy, 0.6, 1}};
  }
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_EUCM_H
