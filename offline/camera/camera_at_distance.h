#ifndef RAYGRID_CAMERA_CAMERA_AT_DISTANCE_H
#define RAYGRID_CAMERA_CAMERA_AT_DISTANCE_H

#include <memory>

#include "camera/camera_model.h"

namespace raygrid {

/// The central camera at the origin that shows what a camera of lines shows of
/// a scene at one distance, in metres from the origin: a pixel looks at the
/// point there that its line passes through. It has no parameters of its own.
class CameraAtDistance : public CameraModel {
 public:
  CameraAtDistance(const CameraModel& lines, double distance_m)
      : CameraModel(lines.image_size(), lines.area()),
        lines_(lines.Clone()),
        distance_m_(distance_m) {}

  std::string Name() const override { return lines_->Name(); }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<CameraAtDistance>(*lines_, distance_m_);
  }
  /// Nothing, too, for a line that does not come as near to the origin as that.
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
  std::unique_ptr<CameraModel> lines_;
  double distance_m_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_AT_DISTANCE_H
