#ifndef RAYGRID_CAMERA_THIN_PRISM_FISHEYE_H
#define RAYGRID_CAMERA_THIN_PRISM_FISHEYE_H

#include <array>

#include "camera/parametric_model.h"

namespace raygrid {

/// The thin-prism fisheye model with 12 parameters (paper, "Evaluation"; J.
/// Weng et al., 1992, on equidistant coordinates, as in COLMAP):
///   rho = |point.xy|,  theta = atan2(rho, point.z)
///   (u, v) = theta point.xy / rho
///   g = 1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8
///   u' = u g + 2 p1 u v + p2 (theta^2 + 2 u^2) + sx1 theta^2
///   v' = v g + p1 (theta^2 + 2 v^2) + 2 p2 u v + sy1 theta^2
///   pixel = (fx u' + cx, fy v' + cy)
/// valid, also behind the camera, up to the first angle at which theta g stops
/// increasing, and up to 3.1 radians.
class ThinPrismFisheye : public ParametricModel {
 public:
  enum { kFx, kFy, kCx, kCy, kK1, kK2, kK3, kK4, kP1, kP2, kSx1, kSy1, kCount };
  using ParameterArray = std::array<double, kCount>;

  ThinPrismFisheye(const ImageSize& image_size, const Area& area,
                   const ParameterArray& parameters);

  std::string Name() const override { return models::kThinPrismFisheye; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<ThinPrismFisheye>(*this);
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

  /// Returns the parameters in the order of the enumeration.
  Eigen::VectorXd Parameters() const override;
  void SetParameters(const Eigen::VectorXd& parameters) override;
  const std::vector<std::string>& ParameterNames() const override;
  std::vector<int> DistortionOrders() const override {
    return {0, 0, 0, 0, 3, 5, 7, 9, -2, -2, -2, -2};
  }
  std::unique_ptr<ParametricModel> CloneWithArea(
      const Area& area) const override {
    return std::make_unique<ThinPrismFisheye>(image_size(), area, parameters_);
  }

  /// Returns the maximum angle theta of the model.
  double max_theta() const { return max_theta_; }

 private:
  ParameterArray parameters_;
  double max_theta_ = 0;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_THIN_PRISM_FISHEYE_H
