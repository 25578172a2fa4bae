#ifndef RAYGRID_SIMULATION_SIMULATED_CAMERA_H
#define RAYGRID_SIMULATION_SIMULATED_CAMERA_H

#include <memory>
#include <vector>

#include "camera/opencv.h"

namespace raygrid {

/// A local deformation of the image, which no parametric model has: pixels
/// around center move by displacement_px exp(-distance^2 / (2 radius_px^2)).
struct LensBump {
  Eigen::Vector2d center;
  Eigen::Vector2d displacement_px;
  double radius_px = 1;
};

/// A known lens: a model without bumps, then bumps. Ground truth for tests; its
/// parameters cannot be adjusted.
class SimulatedCamera : public CameraModel {
 public:
  /// |displacement| / radius must stay well below 1 in total, or the image
  /// would fold.
  SimulatedCamera(const OpenCvModel& lens, std::vector<LensBump> bumps);
  /// A lens that is defined wherever the bumps fetch the area's pixels from.
  SimulatedCamera(std::shared_ptr<const CameraModel> lens, const Area& area,
                  std::vector<LensBump> bumps);

  std::string Name() const override { return "simulated"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<SimulatedCamera>(*this);
  }
  std::optional<Eigen::Vector3d> Unproject(
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
  // The bumps, and their derivative by the pixel.
  Eigen::Vector2d Bend(const Eigen::Vector2d& pixel,
                       Eigen::Matrix2d* derivative) const;

  std::shared_ptr<const CameraModel> lens_;
  std::vector<LensBump> bumps_;
};

/// A 640 x 480 camera with about 62 degrees of horizontal view, barrel
/// distortion, and bumps of up to 1.5 px.
SimulatedCamera ExampleSimulatedCamera();

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_SIMULATED_CAMERA_H
