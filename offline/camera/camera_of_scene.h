#ifndef RAYGRID_CAMERA_CAMERA_OF_SCENE_H
#define RAYGRID_CAMERA_CAMERA_OF_SCENE_H

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "camera/camera_model.h"

namespace raygrid {

/// The surface that a scene lies on, in camera axes and metres: a sphere around
/// the origin, or the points p of a plane, normal · p = distance.
struct SceneSurface {
  double distance_m = 0;
  std::optional<Eigen::Vector3d> normal;  ///< unit; nothing: a sphere
};

/// The central camera at the origin that shows what a camera of lines shows of
/// a scene on a surface: a pixel looks at the point there that its line passes
/// through. It has no parameters of its own.
class CameraOfScene : public CameraModel {
 public:
  CameraOfScene(const CameraModel& lines, const SceneSurface& scene)
      : CameraModel(lines.image_size(), lines.area()),
        lines_(lines.Clone()),
        scene_(scene) {}
  CameraOfScene(const CameraModel& lines, double distance_m)
      : CameraOfScene(lines, SceneSurface{distance_m, std::nullopt}) {}

  std::string Name() const override { return lines_->Name(); }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<CameraOfScene>(*lines_, scene_);
  }
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
  Eigen::VectorXd Parameters() const override { return {}; }
  void SetParameters(const Eigen::VectorXd&) override {}

 private:
  // The direction times this is a point of the surface.
  std::optional<double> Reach(const Eigen::Vector3d& direction) const;

  std::unique_ptr<CameraModel> lines_;
  SceneSurface scene_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_OF_SCENE_H
