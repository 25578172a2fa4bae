#ifndef RAYGRID_CAMERA_OPENCV_14_H
#define RAYGRID_CAMERA_OPENCV_14_H

#include "camera/formula_model.h"

namespace raygrid {

/// OpenCV's model with 14 coefficients: camera/opencv.h's model with a thin
/// prism and a sensor that is rotated about its x axis by tx, then about its y
/// axis by ty, in radians (OpenCV's tauX and tauY):
///   x'' = x' + s1 r^2 + s2 r^4,  y'' = y' + s3 r^2 + s4 r^4
///   R = Ry(ty) Rx(tx),  q = R (x'', y'', 1)
///   x''' = R_33 q_x / q_z - R_13,  y''' = R_33 q_y / q_z - R_23
///   pixel = (fx x''' + cx, fy y''' + cy)
/// for z > 0. For zero s1 to s4, tx and ty it is camera/opencv.h's model.
struct OpenCv14Formula {
  enum {
    kFx,
    kFy,
    kCx,
    kCy,
    kK1,
    kK2,
    kP1,
    kP2,
    kK3,
    kK4,
    kK5,
    kK6,
    kS1,
    kS2,
    kS3,
    kS4,
    kTx,
    kTy,
    kCount
  };
  static constexpr const char* kName = models::kOpenCv14;
  static constexpr double kMaxAngleOfIncidenceRad = 1.52;  // tan is 20

  static const std::vector<std::string>& Names() {
    static const std::vector<std::string> names = {
        "fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3",
        "k4", "k5", "k6", "s1", "s2", "s3", "s4", "tx", "ty"};
    return names;
  }

  template <typename T>
  static T Factor(const T& r2, const T* p) {
    return (1.0 + r2 * (p[kK1] + r2 * (p[kK2] + r2 * p[kK3]))) /
           (1.0 + r2 * (p[kK4] + r2 * (p[kK5] + r2 * p[kK6])));
  }

  /// Rotates (x, y, 1) and projects it along the sensor's axis.
  template <typename T>
  static Eigen::Matrix<T, 2, 1> ProjectOntoTiltedSensor(const T& x, const T& y,
                                                        const T* p) {
    using std::cos;
    using std::sin;
    const T cos_x = cos(p[kTx]), sin_x = sin(p[kTx]);
    const T cos_y = cos(p[kTy]), sin_y = sin(p[kTy]);
    const T q_x = cos_y * x + sin_y * sin_x * y - sin_y * cos_x;
    const T q_y = cos_x * y + sin_x;
    const T q_z = sin_y * x - cos_y * sin_x * y + cos_y * cos_x;
    const T r_33 = cos_y * cos_x;
    return {(r_33 * q_x + sin_y * cos_x * q_z) / q_z,
            (r_33 * q_y - sin_x * q_z) / q_z};
  }

  template <typename T>
  static Eigen::Matrix<T, 2, 1> Pixel(const Eigen::Matrix<T, 3, 1>& point,
                                      const T* p) {
    const T x = point.x() / point.z(), y = point.y() / point.z();
    const T r2 = x * x + y * y, g = Factor(r2, p);
    const T& p1 = p[kP1];
    const T& p2 = p[kP2];
    const T xd = x * g + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) +
                 r2 * (p[kS1] + r2 * p[kS2]);
    const T yd = y * g + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y +
                 r2 * (p[kS3] + r2 * p[kS4]);
    const Eigen::Matrix<T, 2, 1> at = ProjectOntoTiltedSensor(xd, yd, p);
    return {p[kFx] * at.x() + p[kCx], p[kFy] * at.y() + p[kCy]};
  }

  static double Radius(double theta, const double* p) {
    const double r = std::tan(theta), r2 = r * r;
    const double denominator = 1 + r2 * (p[kK4] + r2 * (p[kK5] + r2 * p[kK6]));
    return denominator > 0 ? r * Factor(r2, p) : NAN;
  }

  static std::vector<int> DistortionOrders() {
    return {0, 0, 0, 0, 3, 5, -2, -2, 7, 3, 5, 7, -2, -4, -2, -4, -2, -2};
  }

  static std::vector<std::array<double, kCount>> InitialValues(double f,
                                                               double cx,
                                                               double cy) {
    // Padé approximant of atan(r) / r: an equidistant lens.
    return {{f, f, cx, cy},
            {f, f, cx, cy, 1190 / 1155.0, 231 / 1155.0, 0, 0, 0, 1575 / 1155.0,
             525 / 1155.0, 25 / 1155.0}};
  }
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_OPENCV_14_H
