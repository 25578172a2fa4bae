#ifndef RAYGRID_CAMERA_EQUIVALENT_CENTRAL_CAMERA_H
#define RAYGRID_CAMERA_EQUIVALENT_CENTRAL_CAMERA_H

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "camera/camera_wrapper.h"

namespace raygrid {

/// The surface of a scene, in camera axes and metres: a sphere around the
/// origin, or a plane of points p with normal · p = distance.
struct SceneSurface {
  double distance_m = 0;
  std::optional<Eigen::Vector3d> normal;  ///< unit; nullopt: a sphere
};

/// The central camera at the origin that is equivalent to a non-central camera
/// for a scene on a surface: the direction of a pixel points to the
/// intersection of its observation line with the surface.
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
  /// Returns nullopt also if the line does not intersect the surface.
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
  // Returns the factor that scales the direction to a point on the surface;
  // nullopt if the ray does not intersect the surface.
  std::optional<double> ComputeSurfaceFactor(
      const Eigen::Vector3d& direction) const;

  SceneSurface scene_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_EQUIVALENT_CENTRAL_CAMERA_H
