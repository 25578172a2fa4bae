#include "camera/central_radial.h"

#include <algorithm>

#include "camera/equidistant.h"
#include "camera/paired_jet.h"

namespace raygrid {
namespace {

using Radial = CentralRadial;

// Spline coefficients that determine g at an angle, and their weights.
template <typename T>
struct RadialSupport {
  int first = 0, count = 4;
  std::array<T, 4> weight;
};

inline double GetScalar(double number) { return number; }
template <typename T, int N>
double GetScalar(const ceres::Jet<T, N>& jet) {
  return jet.a;
}

template <typename T>
RadialSupport<T> ComputeSupport(const T& theta, double cell_rad,
                                int num_parameters) {
  const T position = theta / cell_rad;
  const int cell = std::clamp(static_cast<int>(std::floor(GetScalar(position))),
                              0, num_parameters - 2);
  const T t = position - static_cast<double>(cell), s = 1.0 - t;
  // Uniform cubic B-spline weights of s_(cell - 1) to s_(cell + 2).
  const std::array<T, 4> w = {
      s * s * s / 6.0, (4.0 + t * t * (3.0 * t - 6.0)) / 6.0,
      (4.0 + s * s * (3.0 * s - 6.0)) / 6.0, t * t * t / 6.0};
  if (cell == 0) return {0, 2, {w[0] - 0.5 * w[1] + w[2], w[3]}};
  if (cell == 1) return {0, 3, {w[1] - 0.5 * w[0], w[2], w[3]}};
  return {cell - 2, 4, w};
}

template <typename T>
T RadialFactor(const T& theta, double cell_rad,
               const std::vector<double>& spline) {
  const RadialSupport<T> support =
      ComputeSupport(theta, cell_rad, static_cast<int>(spline.size()));
  T g = T(1.0);
  for (int k = 0; k < support.count; ++k)
    g += support.weight[k] * spline[support.first + k];
  return g;
}

template <typename T>
PlanarDistortion<T> MakePlanarDistortion(
    const std::array<T, Radial::kNumPlanarParameters>& p) {
  return {p[Radial::kFx], p[Radial::kFy], p[Radial::kCx],  p[Radial::kCy],
          p[Radial::kP1], p[Radial::kP2], p[Radial::kSx1], p[Radial::kSy1]};
}

// Returns |uv|, with zero derivative in the centre, where the derivative of g
// is zero.
template <typename T>
T Length(const Eigen::Matrix<T, 2, 1>& uv) {
  using std::sqrt;
  const T squared = uv.squaredNorm();
  return squared > 1e-20 ? sqrt(squared) : T(0.0);
}

}  // namespace

CentralRadial::CentralRadial(const ImageSize& image_size, const Area& area,
                             double max_angle_rad, std::vector<double> spline,
                             const PlanarParameters& others)
    : ParametricModel(image_size, area),
      max_angle_rad_(max_angle_rad),
      spline_(std::move(spline)),
      planar_parameters_(others),
      max_theta_(MaxTheta()) {}

double CentralRadial::MaxTheta() const {
  return FindMaxTheta(
      [this](double theta) { return RadialFactor(theta, cell_rad(), spline_); },
      std::min(max_angle_rad_, kMaxTheta));
}

const std::vector<std::string>& CentralRadial::ParameterNames() const {
  static const std::vector<std::string> names = {"fx", "fy", "cx",  "cy",
                                                 "p1", "p2", "sx1", "sy1"};
  return names;
}

std::optional<Eigen::Vector3d> CentralRadial::Unproject(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  using Jet = ceres::Jet<double, 2>;
  std::array<Jet, kNumPlanarParameters> constants;
  for (int k = 0; k < kNumPlanarParameters; ++k)
    constants[k] = Jet(planar_parameters_[k]);
  const PlanarDistortion<Jet> planar = MakePlanarDistortion(constants);
  const Eigen::Vector2d start(
      (pixel.x() - planar_parameters_[kCx]) / planar_parameters_[kFx],
      (pixel.y() - planar_parameters_[kCy]) / planar_parameters_[kFy]);
  const auto uv = InvertDistortion(
      [&](const Eigen::Matrix<Jet, 2, 1>& at) {
        return planar.ToPixel(at,
                              RadialFactor(Length(at), cell_rad(), spline_));
      },
      pixel, start, max_theta_);
  if (!uv) return std::nullopt;
  return FromEquidistant(*uv);
}

std::optional<Eigen::Vector2d> CentralRadial::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* /*start*/,
    double margin_px) const {
  const double theta = std::atan2(point.head<2>().norm(), point.z());
  if (!(theta <= max_theta_) || point.isZero(0)) return std::nullopt;
  const Eigen::Vector2d pixel =
      MakePlanarDistortion(planar_parameters_)
          .ToPixel(ToEquidistant<double>(point),
                   RadialFactor(theta, cell_rad(), spline_));
  if (!area().Contains(pixel, margin_px)) return std::nullopt;
  return pixel;
}

bool CentralRadial::Linearize(const Eigen::Vector3d& point,
                              const Eigen::Vector2d* start, double margin_px,
                              LinearizedProjection* projection) const {
  const auto pixel = Project(point, start, margin_px);
  if (!pixel) return false;
  using Jet = PairedJet<kNumPlanarParameters + 3>;
  std::array<Jet, kNumPlanarParameters> others;
  for (int k = 0; k < kNumPlanarParameters; ++k)
    others[k] = Jet(planar_parameters_[k], k);
  const Eigen::Matrix<Jet, 3, 1> at(Jet(point.x(), kNumPlanarParameters),
                                    Jet(point.y(), kNumPlanarParameters + 1),
                                    Jet(point.z(), kNumPlanarParameters + 2));
  const Eigen::Matrix<Jet, 2, 1> uv = ToEquidistant<Jet>(at);
  const Eigen::Matrix<Jet, 2, 1> value = MakePlanarDistortion(others).ToPixel(
      uv, RadialFactor<Jet>(Length(uv), cell_rad(), spline_));
  projection->pixel = *pixel;
  projection->first_global = static_cast<int>(spline_.size());
  projection->num_global = kNumPlanarParameters;
  for (int row = 0; row < 2; ++row) {
    projection->J_global.row(row).head<kNumPlanarParameters>() =
        value[row].v.head<kNumPlanarParameters>().transpose();
    projection->J_point.row(row) =
        value[row].v.segment<3>(kNumPlanarParameters).transpose();
  }
  const Eigen::Vector2d at_uv(uv[0].a, uv[1].a);
  const RadialSupport<double> support = ComputeSupport(
      at_uv.norm(), cell_rad(), static_cast<int>(spline_.size()));
  projection->num_nodes = static_cast<int>(support.weight.size());
  projection->num_per_node = 1;
  for (int k = 0; k < projection->num_nodes; ++k) {
    const bool is_used = k < support.count;
    projection->node_parameter[k] = support.first + (is_used ? k : 0);
    projection->node_weight[k] = is_used ? support.weight[k] : 0;
  }
  projection->J_node.col(0) << planar_parameters_[kFx] * at_uv.x(),
      planar_parameters_[kFy] * at_uv.y();
  return true;
}

Eigen::VectorXd CentralRadial::Parameters() const {
  Eigen::VectorXd parameters(spline_.size() + kNumPlanarParameters);
  std::copy(spline_.begin(), spline_.end(), parameters.data());
  std::copy(planar_parameters_.begin(), planar_parameters_.end(),
            parameters.data() + spline_.size());
  return parameters;
}

void CentralRadial::SetParameters(const Eigen::VectorXd& parameters) {
  const double* others = parameters.data() + spline_.size();
  std::copy(parameters.data(), others, spline_.begin());
  std::copy(others, others + kNumPlanarParameters, planar_parameters_.begin());
  max_theta_ = MaxTheta();
}

}  // namespace raygrid
