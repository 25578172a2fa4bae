#ifndef RAYGRID_CAMERA_FIXED_CAMERA_H
#define RAYGRID_CAMERA_FIXED_CAMERA_H

#include <memory>

#include "camera/camera_wrapper.h"

namespace raygrid {

/// A camera with known intrinsics, for bundle adjustment: the same observation
/// lines, but no parameters. It has no DirectionGrid() and is not Parametric(),
/// so steps that change or refit cameras skip it.
class FixedCamera : public CameraWrapper {
 public:
  explicit FixedCamera(const CameraModel& camera)
      : CameraWrapper(camera, camera.image_size(), camera.area()) {}

  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<FixedCamera>(camera());
  }
  std::unique_ptr<CameraModel> FittedTo(const CameraModel&) const override {
    return Clone();
  }
  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override {
    return camera().Unproject(pixel);
  }
  std::optional<ObservationLine> Line(
      const Eigen::Vector2d& pixel) const override {
    return camera().Line(pixel);
  }
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* start,
                                         double margin_px) const override {
    return camera().Project(point, start, margin_px);
  }
  using CameraModel::Project;
  bool Linearize(const Eigen::Vector3d& point, const Eigen::Vector2d* start,
                 double margin_px,
                 LinearizedProjection* projection) const override {
    if (!camera().Linearize(point, start, margin_px, projection)) return false;
    ForgetParameters(projection);
    return true;
  }
};

/// Returns whether a camera's intrinsics are held fixed.
inline bool IsFixed(const CameraModel& camera) {
  return dynamic_cast<const FixedCamera*>(&camera) != nullptr;
}

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_FIXED_CAMERA_H
