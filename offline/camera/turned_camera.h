#ifndef RAYGRID_CAMERA_TURNED_CAMERA_H
#define RAYGRID_CAMERA_TURNED_CAMERA_H

#include <Eigen/Geometry>
#include <memory>

#include "camera/camera_model.h"

namespace raygrid {

/// A camera whose frame is turned against another one's: exactly the same
/// lines, for measuring and fitting. It has no parameters of its own.
class TurnedCamera : public CameraModel {
 public:
  TurnedCamera(const CameraModel& camera,
               const Eigen::Quaterniond& turned_from_camera)
      : CameraModel(camera.image_size(), camera.area()),
        camera_(camera.Clone()),
        turned_from_camera_(turned_from_camera) {}

  std::string Name() const override { return camera_->Name(); }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<TurnedCamera>(*camera_, turned_from_camera_);
  }
  bool IsCentral() const override { return camera_->IsCentral(); }
  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override;
  std::optional<ObservationLine> Line(
      const Eigen::Vector2d& pixel) const override;
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* start,
                                         double margin_px) const override;
  using CameraModel::Project;
  bool Linearize(const Eigen::Vector3d& point, const Eigen::Vector2d* start,
                 double margin_px,
                 LinearizedProjection* projection) const override;
  Eigen::VectorXd Parameters() const override { return {}; }
  void SetParameters(const Eigen::VectorXd&) override {}

 private:
  std::unique_ptr<CameraModel> camera_;
  Eigen::Quaterniond turned_from_camera_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_TURNED_CAMERA_H
