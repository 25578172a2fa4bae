#include "camera/thin_prism_fisheye.h"

#include "camera/equidistant.h"
#include "camera/paired_jet.h"

namespace raygrid {
namespace {

using Prism = ThinPrismFisheye;

template <typename T>
T RadialFactor(const T& theta2, const T* p) {
  return 1.0 +
         theta2 *
             (p[Prism::kK1] +
              theta2 * (p[Prism::kK2] +
                        theta2 * (p[Prism::kK3] + theta2 * p[Prism::kK4])));
}

// Projects equidistant coordinates to pixels by the equations of the header.
template <typename T>
Eigen::Matrix<T, 2, 1> Distort(const Eigen::Matrix<T, 2, 1>& uv, const T* p) {
  const PlanarDistortion<T> planar = {
      p[Prism::kFx], p[Prism::kFy], p[Prism::kCx],  p[Prism::kCy],
      p[Prism::kP1], p[Prism::kP2], p[Prism::kSx1], p[Prism::kSy1]};
  return planar.ToPixel(uv, RadialFactor(T(uv.squaredNorm()), p));
}

double ComputeMaxTheta(const Prism::ParameterArray& p) {
  return FindMaxTheta(
      [&p](double theta) { return RadialFactor(theta * theta, p.data()); },
      kMaxTheta);
}

}  // namespace

ThinPrismFisheye::ThinPrismFisheye(const ImageSize& image_size,
                                   const Area& area,
                                   const ParameterArray& parameters)
    : ParametricModel(image_size, area),
      parameters_(parameters),
      max_theta_(ComputeMaxTheta(parameters)) {}

const std::vector<std::string>& ThinPrismFisheye::ParameterNames() const {
  static const std::vector<std::string> names = {
      "fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4", "p1", "p2", "sx1", "sy1"};
  return names;
}

std::optional<Eigen::Vector3d> ThinPrismFisheye::Unproject(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  using Jet = ceres::Jet<double, 2>;
  std::array<Jet, kCount> constants;
  for (int k = 0; k < kCount; ++k) constants[k] = Jet(parameters_[k]);
  const Eigen::Vector2d start(
      (pixel.x() - parameters_[kCx]) / parameters_[kFx],
      (pixel.y() - parameters_[kCy]) / parameters_[kFy]);
  const auto uv = InvertDistortion(
      [&](const Eigen::Matrix<Jet, 2, 1>& at) {
        return Distort<Jet>(at, constants.data());
      },
      pixel, start, max_theta_);
  if (!uv) return std::nullopt;
  return FromEquidistant(*uv);
}

std::optional<Eigen::Vector2d> ThinPrismFisheye::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* /*start*/,
    double margin_px) const {
  const double theta = std::atan2(point.head<2>().norm(), point.z());
  if (!(theta <= max_theta_) || point.isZero(0)) return std::nullopt;
  const Eigen::Vector2d pixel =
      Distort<double>(ToEquidistant<double>(point), parameters_.data());
  if (!area().Contains(pixel, margin_px)) return std::nullopt;
  return pixel;
}

bool ThinPrismFisheye::Linearize(const Eigen::Vector3d& point,
                                 const Eigen::Vector2d* start, double margin_px,
                                 LinearizedProjection* projection) const {
  const auto pixel = Project(point, start, margin_px);
  if (!pixel) return false;
  using Jet = PairedJet<kCount + 3>;
  std::array<Jet, kCount> parameters;
  for (int k = 0; k < kCount; ++k) parameters[k] = Jet(parameters_[k], k);
  const Eigen::Matrix<Jet, 3, 1> at(Jet(point.x(), kCount),
                                    Jet(point.y(), kCount + 1),
                                    Jet(point.z(), kCount + 2));
  const Eigen::Matrix<Jet, 2, 1> value =
      Distort<Jet>(ToEquidistant<Jet>(at), parameters.data());
  projection->pixel = *pixel;
  projection->num_global = kCount;
  for (int row = 0; row < 2; ++row) {
    projection->J_global.row(row).head<kCount>() =
        value[row].v.head<kCount>().transpose();
    projection->J_point.row(row) = value[row].v.segment<3>(kCount).transpose();
  }
  return true;
}

Eigen::VectorXd ThinPrismFisheye::Parameters() const {
  return Eigen::Map<const Eigen::VectorXd>(parameters_.data(), kCount);
}

void ThinPrismFisheye::SetParameters(const Eigen::VectorXd& parameters) {
  Eigen::Map<Eigen::VectorXd>(parameters_.data(), kCount) = parameters;
  max_theta_ = ComputeMaxTheta(parameters_);
}

}  // namespace raygrid
