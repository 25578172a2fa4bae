#ifndef RAYGRID_CAMERA_OMNI_RADTAN_H
#define RAYGRID_CAMERA_OMNI_RADTAN_H

#include "camera/formula_model.h"

namespace raygrid {

/// The unified model (C. Mei, P. Rives, ICRA 2007), as Kalibr's omni-radtan and
/// OpenCV's omnidir without skew:
///   (x, y) = point.xy / (point.z + xi |point|),  r^2 = x^2 + y^2
///   g = 1 + k1 r^2 + k2 r^4
///   x' = x g + 2 p1 x y + p2 (r^2 + 2 x^2)
///   y' = y g + p1 (r^2 + 2 y^2) + 2 p2 x y
///   pixel = (fx x' + cx, fy y' + cy)
struct OmniRadtanFormula {
  enum { kFx, kFy, kCx, kCy, kXi, kK1, kK2, kP1, kP2, kCount };
  static constexpr const char* kName = models::kOmniRadtan;
  static constexpr double kMaxAngleOfIncidenceRad = kMaxTheta;

  static const std::vector<std::string>& Names() {
    static const std::vector<std::string> names = {"fx", "fy", "cx", "cy", "xi",
                                                   "k1", "k2", "p1", "p2"};
    return names;
  }

  template <typename T>
  static Eigen::Matrix<T, 2, 1> Pixel(const Eigen::Matrix<T, 3, 1>& point,
                                      const T* p) {
    const T depth = point.z() + p[kXi] * point.norm();
    const T x = point.x() / depth, y = point.y() / depth;
    const T r2 = x * x + y * y, g = 1.0 + r2 * (p[kK1] + r2 * p[kK2]);
    const T& p1 = p[kP1];
    const T& p2 = p[kP2];
    const T xd = x * g + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
    const T yd = y * g + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
    return {p[kFx] * xd + p[kCx], p[kFy] * yd + p[kCy]};
  }

  static double Radius(double theta, const double* p) {
    const double depth = std::cos(theta) + p[kXi];
    const double r = std::sin(theta) / depth, r2 = r * r;
    return depth > 0 ? r * (1 + r2 * (p[kK1] + r2 * p[kK2])) : NAN;
  }

  static std::vector<int> DistortionOrders() {
    return {0, 0, 0, 0, 3, 3, 5, -2, -2};
  }

  static std::vector<std::array<double, kCount>> InitialValues(double f,
                                                               double cx,
                                                               double cy) {
    return {{2 * f, 2 * f, cx, cy, 1}};
  }
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_OMNI_RADTAN_H
