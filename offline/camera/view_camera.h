#ifndef RAYGRID_CAMERA_VIEW_CAMERA_H
#define RAYGRID_CAMERA_VIEW_CAMERA_H

#include "camera/parametric_model.h"
#include "camera/view_projection.h"

namespace raygrid {

/// The virtual camera of an image undistorted to a projection other than the
/// pinhole, which is "opencv" without distortion. The model is named after its
/// projection.
class ViewCamera : public ParametricModel {
 public:
  /// parameters: fx, fy, cx, cy.
  ViewCamera(ViewProjection projection, const ImageSize& image_size,
             const Area& area, const Eigen::Vector4d& parameters)
      : ParametricModel(image_size, area),
        projection_(projection),
        parameters_(parameters) {}

  std::string Name() const override { return ProjectionName(projection_); }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<ViewCamera>(*this);
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
  Eigen::VectorXd Parameters() const override { return parameters_; }
  void SetParameters(const Eigen::VectorXd& parameters) override {
    parameters_ = parameters;
  }
  const std::vector<std::string>& ParameterNames() const override;
  std::unique_ptr<ParametricModel> CloneWithArea(
      const Area& area) const override {
    return std::make_unique<ViewCamera>(projection_, image_size(), area,
                                        parameters_);
  }

  ViewProjection projection() const { return projection_; }

 private:
  ViewProjection projection_;
  Eigen::Vector4d parameters_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_VIEW_CAMERA_H
