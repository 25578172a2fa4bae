/// Parametric models with a closed formula, one file each. A Formula has
///   kName, kCount;
///   Names(): fx, fy, cx, cy, then the other parameters, as in camera.yaml;
///   Pixel(point, parameters): projection of a point in front of the lens,
///     for numbers and jets;
///   Radius(theta, parameters): distance from the principal point, in focal
///     lengths, of a direction at this angle from the axis, without tilt and
///     tangential terms; NaN where the formula is undefined;
///   kMaxAngleOfIncidenceRad: maximum angle of the formula;
///   DistortionOrders(): ParametricModel's;
///   InitialValues(f, cx, cy): initial parameters of fits, for a focal
///     length of f pixels per radian in the centre.
#ifndef RAYGRID_CAMERA_FORMULA_MODEL_H
#define RAYGRID_CAMERA_FORMULA_MODEL_H

#include <array>
#include <memory>

#include "camera/equidistant.h"
#include "camera/paired_jet.h"
#include "camera/parametric_model.h"

namespace raygrid {

/// Valid up to the first angle at which the radius stops increasing.
template <typename Formula>
class FormulaModel : public ParametricModel {
 public:
  static constexpr int kCount = Formula::kCount;
  using ParameterArray = std::array<double, kCount>;

  FormulaModel(const ImageSize& image_size, const Area& area,
               const ParameterArray& parameters)
      : ParametricModel(image_size, area), parameters_(parameters) {
    ComputeMaxAngle();
  }

  std::string Name() const override { return Formula::kName; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<FormulaModel>(*this);
  }

  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override {
    if (!area().Contains(pixel)) return std::nullopt;
    using Jet = ceres::Jet<double, 2>;
    std::array<Jet, kCount> constants;
    for (int k = 0; k < kCount; ++k) constants[k] = Jet(parameters_[k]);
    const auto distort = [&](const Eigen::Matrix<Jet, 2, 1>& uv) {
      return Formula::Pixel(DirectionAt(uv), constants.data());
    };
    const auto uv = InvertDistortion(
        distort, pixel, ApproximateEquidistant(pixel), max_angle_rad_);
    if (!uv) return std::nullopt;
    return FromEquidistant(*uv);
  }

  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* /*start*/,
                                         double margin_px) const override {
    const double theta = std::atan2(point.head<2>().norm(), point.z());
    if (!(theta <= max_angle_rad_) || point.isZero(0)) return std::nullopt;
    const Eigen::Vector2d pixel = Formula::Pixel(point, parameters_.data());
    if (!area().Contains(pixel, margin_px)) return std::nullopt;
    return pixel;
  }
  using CameraModel::Project;

  bool Linearize(const Eigen::Vector3d& point, const Eigen::Vector2d* start,
                 double margin_px,
                 LinearizedProjection* projection) const override {
    const auto pixel = Project(point, start, margin_px);
    if (!pixel) return false;
    using Jet = PairedJet<kCount + 3>;
    std::array<Jet, kCount> parameters;
    for (int k = 0; k < kCount; ++k) parameters[k] = Jet(parameters_[k], k);
    Eigen::Matrix<Jet, 3, 1> at;
    for (int k = 0; k < 3; ++k) at[k] = Jet(point[k], kCount + k);
    const Eigen::Matrix<Jet, 2, 1> value =
        Formula::Pixel(at, parameters.data());
    projection->pixel = *pixel;
    projection->num_global = kCount;
    for (int row = 0; row < 2; ++row) {
      projection->J_global.row(row).template head<kCount>() =
          value[row].v.template head<kCount>().transpose();
      projection->J_point.row(row) =
          value[row].v.template segment<3>(kCount).transpose();
    }
    return true;
  }

  Eigen::VectorXd Parameters() const override {
    return Eigen::Map<const Eigen::VectorXd>(parameters_.data(), kCount);
  }
  void SetParameters(const Eigen::VectorXd& parameters) override {
    Eigen::Map<Eigen::VectorXd>(parameters_.data(), kCount) = parameters;
    ComputeMaxAngle();
  }
  const std::vector<std::string>& ParameterNames() const override {
    return Formula::Names();
  }
  std::vector<int> DistortionOrders() const override {
    return Formula::DistortionOrders();
  }
  std::unique_ptr<ParametricModel> CloneWithArea(
      const Area& area) const override {
    return std::make_unique<FormulaModel>(image_size(), area, parameters_);
  }

 private:
  void ComputeMaxAngle() {
    max_angle_rad_ = FindMaxTheta(
        [this](double theta) {
          return Formula::Radius(theta, parameters_.data()) / theta;
        },
        Formula::kMaxAngleOfIncidenceRad);
    // Lattice of angles for initial values of the pixel search.
    for (int k = 0; k <= kStarts; ++k)
      start_radius_[k] =
          Formula::Radius(max_angle_rad_ * k / kStarts, parameters_.data());
  }

  // Returns approximate equidistant coordinates of a pixel, without tilt and
  // tangential terms.
  Eigen::Vector2d ApproximateEquidistant(const Eigen::Vector2d& pixel) const {
    const Eigen::Vector2d at((pixel.x() - parameters_[2]) / parameters_[0],
                             (pixel.y() - parameters_[3]) / parameters_[1]);
    const double radius = at.norm();
    if (!(radius > 0)) return Eigen::Vector2d::Zero();
    int k = 1;
    while (k < kStarts && start_radius_[k] < radius) ++k;
    const double below = start_radius_[k - 1], above = start_radius_[k];
    const double part =
        above > below ? std::min((radius - below) / (above - below), 1.0) : 0;
    return at / radius * (max_angle_rad_ * (k - 1 + part) / kStarts);
  }

  static constexpr int kStarts = 16;
  ParameterArray parameters_;
  double max_angle_rad_ = 0;
  std::array<double, kStarts + 1> start_radius_ = {};
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_FORMULA_MODEL_H
