#ifndef RAYGRID_CAMERA_STACKED_GRID_H
#define RAYGRID_CAMERA_STACKED_GRID_H

#include "camera/camera_stack.h"

namespace raygrid {

/// A stack as a camera: what it is at one value of the condition, with the
/// parameters of the whole stack. A node's are a, b of c_0, then of c_1, and so
/// on.
class StackedGrid : public CameraModel {
 public:
  StackedGrid(CameraStack stack, double value);

  std::string Name() const override { return camera_.Name(); }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<StackedGrid>(*this);
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

  const CameraStack& stack() const { return stack_; }
  double value() const { return value_; }
  /// Goes to another value of the condition.
  void SetValue(double value);
  const CentralGeneric& camera() const { return camera_; }

 private:
  CameraStack stack_;
  double value_;
  std::vector<double> powers_;
  CentralGeneric camera_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_STACKED_GRID_H
