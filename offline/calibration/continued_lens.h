#ifndef RAYGRID_CALIBRATION_CONTINUED_LENS_H
#define RAYGRID_CALIBRATION_CONTINUED_LENS_H

#include <memory>

#include "camera/camera_model.h"

namespace raygrid {

/// A lens that gives each pixel of an area a direction, for a grid to start
/// from: its own up to an angle from its axis, farther out an equidistant
/// lens's. In the corners around a fisheye's image circle there is nothing to
/// see, and a polynomial goes astray. Where it ends long before that angle,
/// there is no direction.
class ContinuedLens : public CameraModel {
 public:
  ContinuedLens(const CameraModel& lens, const Area& area,
                double max_angle_rad);

  std::string Name() const override { return lens_->Name(); }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<ContinuedLens>(*this);
  }
  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override;
  /// As the lens does; and its parameters are the lens's, and fixed.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* start,
                                         double margin_px) const override {
    return lens_->Project(point, start, margin_px);
  }
  using CameraModel::Project;
  bool Linearize(const Eigen::Vector3d& point, const Eigen::Vector2d* start,
                 double margin_px,
                 LinearizedProjection* projection) const override {
    return lens_->Linearize(point, start, margin_px, projection);
  }
  Eigen::VectorXd Parameters() const override { return {}; }
  void SetParameters(const Eigen::VectorXd&) override {}

 private:
  // The direction at an angle from the axis, to the side of an offset from the
  // centre in the image.
  static Eigen::Vector3d Direction(double angle_rad,
                                   const Eigen::Vector2d& side);

  std::shared_ptr<const CameraModel> lens_;
  double max_angle_rad_;
  Eigen::Vector2d center_ = Eigen::Vector2d::Zero();
  double focal_px_ = 0;  // 0: the lens does not look straight ahead
};

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CONTINUED_LENS_H
