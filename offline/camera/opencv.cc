#include "camera/opencv.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "camera/paired_jet.h"

namespace raygrid {
namespace {

using OpenCv = OpenCvModel;

// Projects normalized coordinates to pixels by the equations of the header.
template <typename T>
Eigen::Matrix<T, 2, 1> DistortOpenCv(const T& x, const T& y, const T* p) {
  const T r2 = x * x + y * y;
  const T g =
      (1.0 +
       r2 * (p[OpenCv::kK1] + r2 * (p[OpenCv::kK2] + r2 * p[OpenCv::kK3]))) /
      (1.0 +
       r2 * (p[OpenCv::kK4] + r2 * (p[OpenCv::kK5] + r2 * p[OpenCv::kK6])));
  const T& p1 = p[OpenCv::kP1];
  const T& p2 = p[OpenCv::kP2];
  const T xd = x * g + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
  const T yd = y * g + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
  return {p[OpenCv::kFx] * xd + p[OpenCv::kCx],
          p[OpenCv::kFy] * yd + p[OpenCv::kCy]};
}

// Returns the radius up to which r g(r) increases and the denominator of g is
// positive.
double ComputeMaxRadius(const OpenCv::ParameterArray& p) {
  constexpr double kStep = 0.01, kMaxRadius = 20;  // tan(87 degrees)
  double previous = 0;
  for (double r = kStep; r < kMaxRadius; r += kStep) {
    const double r2 = r * r;
    const double denominator =
        1 + r2 * (p[OpenCv::kK4] + r2 * (p[OpenCv::kK5] + r2 * p[OpenCv::kK6]));
    const double numerator =
        1 + r2 * (p[OpenCv::kK1] + r2 * (p[OpenCv::kK2] + r2 * p[OpenCv::kK3]));
    const double distorted = r * numerator / denominator;
    if (denominator <= 0 || distorted <= previous) return r - kStep;
    previous = distorted;
  }
  return kMaxRadius;
}

// Inverts the distortion by Newton's method; with damping, steps never increase
// the error.
std::optional<Eigen::Vector2d> UndistortFromStart(
    Eigen::Vector2d at, bool is_damped, const Eigen::Vector2d& pixel,
    const OpenCv::ParameterArray& p, double max_radius) {
  using Jet = ceres::Jet<double, 2>;
  std::array<Jet, OpenCv::kCount> constants;
  for (int k = 0; k < OpenCv::kCount; ++k) constants[k] = Jet(p[k]);
  for (int iteration = 0; iteration < 50; ++iteration) {
    const auto value =
        DistortOpenCv(Jet(at.x(), 0), Jet(at.y(), 1), constants.data());
    Eigen::Matrix2d derivative;
    derivative << value[0].v.transpose(), value[1].v.transpose();
    const Eigen::Vector2d error =
        pixel - Eigen::Vector2d(value[0].a, value[1].a);
    if (error.norm() < 1e-10) return at;
    Eigen::Vector2d step = derivative.inverse() * error;
    if (!step.allFinite()) return std::nullopt;
    // Limits the step to the invertible domain.
    while ((at + step).norm() > max_radius && step.norm() > 1e-12) step /= 2;
    const auto is_worse = [&] {
      const Eigen::Vector2d next = at + step;
      return (pixel - DistortOpenCv(next.x(), next.y(), p.data())).norm() >
             error.norm();
    };
    while (is_damped && step.norm() > 1e-12 && is_worse()) step /= 2;
    at += step;
    if (step.norm() < 1e-15)
      return error.norm() < 1e-7 ? std::optional(at) : std::nullopt;
  }
  return std::nullopt;
}

// Undistorts the position of a pixel without the tangential distortion.
Eigen::Vector2d UndistortRadially(const Eigen::Vector2d& distorted,
                                  const OpenCv::ParameterArray& p,
                                  double max_radius) {
  OpenCv::ParameterArray radial = p;
  radial[OpenCv::kFx] = radial[OpenCv::kFy] = 1;
  for (const int k : {OpenCv::kCx, OpenCv::kCy, OpenCv::kP1, OpenCv::kP2})
    radial[k] = 0;
  const double radius = distorted.norm();
  double low = 0, high = max_radius;
  for (int k = 0; k < 50; ++k) {
    const double midpoint = (low + high) / 2;
    (DistortOpenCv(midpoint, 0.0, radial.data()).x() < radius ? low : high) =
        midpoint;
  }
  return radius > 0 ? Eigen::Vector2d(distorted * (low / radius)) : distorted;
}

// Undistorts a pixel, starting from the distorted position; if that diverges,
// e.g. at a local extremum of the distortion, from the position undistorted
// without the tangential distortion.
std::optional<Eigen::Vector2d> Undistort(const Eigen::Vector2d& pixel,
                                         const OpenCv::ParameterArray& p,
                                         double max_radius) {
  const Eigen::Vector2d distorted(
      (pixel.x() - p[OpenCv::kCx]) / p[OpenCv::kFx],
      (pixel.y() - p[OpenCv::kCy]) / p[OpenCv::kFy]);
  Eigen::Vector2d start = distorted;
  if (start.norm() > 0.9 * max_radius) start *= 0.9 * max_radius / start.norm();
  if (const auto found = UndistortFromStart(start, false, pixel, p, max_radius))
    return found;
  return UndistortFromStart(UndistortRadially(distorted, p, max_radius), true,
                            pixel, p, max_radius);
}

}  // namespace

const std::vector<std::string>& OpenCvModel::ParameterNames() const {
  static const std::vector<std::string> names = {
      "fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"};
  return names;
}

OpenCvModel::OpenCvModel(const ImageSize& image_size, const Area& area,
                         const ParameterArray& parameters)
    : ParametricModel(image_size, area),
      parameters_(parameters),
      max_radius_(ComputeMaxRadius(parameters)) {}

std::optional<Eigen::Vector3d> OpenCvModel::Unproject(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  const auto undistorted = Undistort(pixel, parameters_, max_radius_);
  if (!undistorted) return std::nullopt;
  return undistorted->homogeneous().normalized();
}

std::optional<Eigen::Vector2d> OpenCvModel::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* /*start*/,
    double margin_px) const {
  if (!(point.z() > 0) || point.head<2>().norm() > max_radius_ * point.z())
    return std::nullopt;
  const Eigen::Vector2d pixel = DistortOpenCv(
      point.x() / point.z(), point.y() / point.z(), parameters_.data());
  if (!area().Contains(pixel, margin_px)) return std::nullopt;
  return pixel;
}

bool OpenCvModel::Linearize(const Eigen::Vector3d& point,
                            const Eigen::Vector2d* start, double margin_px,
                            LinearizedProjection* projection) const {
  const auto pixel = Project(point, start, margin_px);
  if (!pixel) return false;
  using Jet = PairedJet<kCount + 3>;
  std::array<Jet, kCount> parameters;
  for (int k = 0; k < kCount; ++k) parameters[k] = Jet(parameters_[k], k);
  const Jet x(point.x(), kCount), y(point.y(), kCount + 1),
      z(point.z(), kCount + 2);
  const Eigen::Matrix<Jet, 2, 1> value =
      DistortOpenCv<Jet>(x / z, y / z, parameters.data());
  projection->pixel = *pixel;
  projection->num_global = kCount;
  for (int row = 0; row < 2; ++row) {
    projection->J_global.row(row).head<kCount>() =
        value[row].v.head<kCount>().transpose();
    projection->J_point.row(row) = value[row].v.segment<3>(kCount).transpose();
  }
  return true;
}

Eigen::VectorXd OpenCvModel::Parameters() const {
  return Eigen::Map<const Eigen::VectorXd>(parameters_.data(), kCount);
}

void OpenCvModel::SetParameters(const Eigen::VectorXd& parameters) {
  Eigen::Map<Eigen::VectorXd>(parameters_.data(), kCount) = parameters;
  max_radius_ = ComputeMaxRadius(parameters_);
}

OpenCvModel OpenCvModel::WithArea(const Area& area) const {
  return OpenCvModel(image_size(), area, parameters_);
}

}  // namespace raygrid
