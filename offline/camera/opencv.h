#ifndef RAYGRID_CAMERA_OPENCV_H
#define RAYGRID_CAMERA_OPENCV_H

#include <array>

#include "camera/parametric_model.h"

namespace raygrid {

/// OpenCV's rational model with 12 parameters (paper, "Evaluation"):
///   (x, y) = point.xy / point.z,  r^2 = x^2 + y^2
///   g = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)
///   x' = x g + 2 p1 x y + p2 (r^2 + 2 x^2)
///   y' = y g + p1 (r^2 + 2 y^2) + 2 p2 x y
///   pixel = (fx x' + cx, fy y' + cy)
/// valid for z > 0 and radii up to the first at which r g stops increasing.
class OpenCvModel : public ParametricModel {
 public:
  enum { kFx, kFy, kCx, kCy, kK1, kK2, kK3, kK4, kK5, kK6, kP1, kP2, kCount };
  using ParameterArray = std::array<double, kCount>;

  OpenCvModel(const ImageSize& image_size, const Area& area,
              const ParameterArray& parameters);

  std::string Name() const override { return models::kOpenCv; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<OpenCvModel>(*this);
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
    return {0, 0, 0, 0, 3, 5, 7, 3, 5, 7, -2, -2};
  }

  OpenCvModel WithArea(const Area& area) const;
  std::unique_ptr<ParametricModel> CloneWithArea(
      const Area& area) const override {
    return std::make_unique<OpenCvModel>(WithArea(area));
  }

 private:
  ParameterArray parameters_;
  double max_radius_ = 0;  // maximum norm of (x, y)
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_OPENCV_H
