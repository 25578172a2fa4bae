#ifndef RAYGRID_CAMERA_OPERATING_POINT_GRID_H
#define RAYGRID_CAMERA_OPERATING_POINT_GRID_H

#include "camera/operating_point_model.h"

namespace raygrid {

/// An operating-point model as a camera at one operating point, with the
/// parameters of the whole model. A node's parameters are a, b of the first
/// term, then a, b of the second, and so on.
class OperatingPointGrid : public CameraModel {
 public:
  OperatingPointGrid(OperatingPointModel stack, OperatingPoint values);

  std::string Name() const override { return camera_.Name(); }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<OperatingPointGrid>(*this);
  }
  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override {
    return camera_.Unproject(pixel);
  }
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* start,
                                         double margin_px) const override {
    return camera_.Project(point, start, margin_px);
  }
  using CameraModel::Project;
  bool Linearize(const Eigen::Vector3d& point, const Eigen::Vector2d* start,
                 double margin_px,
                 LinearizedProjection* projection) const override;
  Eigen::VectorXd Parameters() const override;
  void SetParameters(const Eigen::VectorXd& parameters) override;

  const OperatingPointModel& stack() const { return model_; }
  const OperatingPointModel* GetOperatingPointModel() const override {
    return &model_;
  }
  const OperatingPoint& values() const { return values_; }
  /// Changes the operating point.
  void SetValues(OperatingPoint values);
  const CentralGeneric& camera() const { return camera_; }

 private:
  OperatingPointModel model_;
  OperatingPoint values_;
  std::vector<double> factors_;
  CentralGeneric camera_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_OPERATING_POINT_GRID_H
