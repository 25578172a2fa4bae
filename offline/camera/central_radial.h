#ifndef RAYGRID_CAMERA_CENTRAL_RADIAL_H
#define RAYGRID_CAMERA_CENTRAL_RADIAL_H

#include <array>
#include <vector>

#include "camera/parametric_model.h"

namespace raygrid {

/// The central radial model (paper, "Evaluation"): the thin-prism fisheye's
/// equations with a spline for its radial factor,
///   g(theta) = 1 + sum_k B(theta / h - k) s_k,  k = -1 .. n,
/// where B is the uniform cubic B-spline of support (-2, 2) and
/// h = max_angle / (n - 1), so that the last cell ends at max_angle. The
/// control points s_1 .. s_n are parameters. g is even, s_-1 = s_1, and g(0) =
/// 1, s_0 = -s_1 / 2: fx and fy are the focal lengths in the centre. Valid up
/// to max_angle or the first angle at which theta g stops increasing.
class CentralRadial : public ParametricModel {
 public:
  /// The parameters that follow the spline's control points.
  enum { kFx, kFy, kCx, kCy, kP1, kP2, kSx1, kSy1, kNumPlanarParameters };
  using PlanarParameters = std::array<double, kNumPlanarParameters>;

  /// spline: s_1 .. s_n, n >= 3; max_angle up to 3.1 radians.
  CentralRadial(const ImageSize& image_size, const Area& area,
                double max_angle_rad, std::vector<double> spline,
                const PlanarParameters& others);

  std::string Name() const override { return models::kCentralRadial; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<CentralRadial>(*this);
  }
  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override;
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* start,
                                         double margin_px) const override;
  using CameraModel::Project;
  bool Linearize(const Eigen::Vector3d& point, const Eigen::Vector2d* start,
                 double margin_px,
                 LinearizedProjection* projection) const override;

  /// Returns the spline control points, followed by the remaining parameters.
  Eigen::VectorXd Parameters() const override;
  void SetParameters(const Eigen::VectorXd& parameters) override;
  /// Names of the parameters after the control points.
  const std::vector<std::string>& ParameterNames() const override;
  std::vector<int> DistortionOrders() const override {
    return {0, 0, 0, 0, -2, -2, -2, -2};
  }
  std::unique_ptr<ParametricModel> CloneWithArea(
      const Area& area) const override {
    return std::make_unique<CentralRadial>(image_size(), area, max_angle_rad_,
                                           spline_, planar_parameters_);
  }

  double max_angle_rad() const { return max_angle_rad_; }
  const std::vector<double>& spline() const { return spline_; }
  const PlanarParameters& others() const { return planar_parameters_; }
  /// Returns the angle between adjacent control points.
  double cell_rad() const {
    return max_angle_rad_ / (static_cast<double>(spline_.size()) - 1);
  }

 private:
  double MaxTheta() const;

  double max_angle_rad_;
  std::vector<double> spline_;
  PlanarParameters planar_parameters_;
  double max_theta_ = 0;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CENTRAL_RADIAL_H
