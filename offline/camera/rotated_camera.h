#ifndef RAYGRID_CAMERA_ROTATED_CAMERA_H
#define RAYGRID_CAMERA_ROTATED_CAMERA_H

#include <Eigen/Geometry>
#include <memory>

#include "camera/camera_wrapper.h"

namespace raygrid {

/// A camera in a rotated frame, with exactly the same observation lines.
class RotatedCamera : public CameraWrapper {
 public:
  RotatedCamera(const CameraModel& camera,
                const Eigen::Quaterniond& rotated_from_camera)
      : CameraWrapper(camera, camera.image_size(), camera.area()),
        rotated_from_camera_(rotated_from_camera) {}

  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<RotatedCamera>(camera(), rotated_from_camera_);
  }
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

 private:
  Eigen::Quaterniond rotated_from_camera_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_ROTATED_CAMERA_H
