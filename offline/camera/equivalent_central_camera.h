#ifndef RAYGRID_CAMERA_EQUIVALENT_CENTRAL_CAMERA_H
#define RAYGRID_CAMERA_EQUIVALENT_CENTRAL_CAMERA_H

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "camera/camera_wrapper.h"

namespace raygrid {

/// The surface that a scene lies on, in camera axes and metres: a sphere around
/// the origin, or the points p of a plane, normal · p = distance.
struct SceneSurface {
  double distance_m = 0;
  std::optional<Eigen::Vector3d> normal;  ///< unit; nothing: a sphere
};

/// The central camera at the origin that shows what a camera of lines shows of
/// a scene on a surface: a pixel looks at the point there that its line passes
/// through.
class EquivalentCentralCamera : public CameraWrapper {
 public:
  EquivalentCentralCamera(const CameraModel& lines, const SceneSurface& scene)
      : CameraWrapper(lines, lines.image_size(), lines.area()), scene_(scene) {}
  EquivalentCentralCamera(const CameraModel& lines, double distance_m)
      : EquivalentCentralCamera(lines, SceneSurface{distance_m, std::nullopt}) {
  }

  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<EquivalentCentralCamera>(camera(), scene_);
  }
  bool IsCentral() const override { return true; }
  /// Nothing, too, for a line that does not meet the surface.
  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override;
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& direction,
                                         const Eigen::Vector2d* start,
                                         double margin_px) const override;
  using CameraModel::Project;
  bool Linearize(const Eigen::Vector3d& direction, const Eigen::Vector2d* start,
                 double margin_px,
                 LinearizedProjection* projection) const override;

 private:
  // The direction times this is a point of the surface.
  std::optional<double> Reach(const Eigen::Vector3d& direction) const;

  SceneSurface scene_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_EQUIVALENT_CENTRAL_CAMERA_H
