#ifndef RAYGRID_SIMULATION_SIMULATED_CAMERA_H
#define RAYGRID_SIMULATION_SIMULATED_CAMERA_H

#include <memory>
#include <vector>

#include "camera/opencv.h"

namespace raygrid {

/// A local distortion that no parametric model represents: pixels around center
/// move by displacement_px exp(-distance^2 / (2 radius_px^2)).
struct DistortionBump {
  Eigen::Vector2d center;
  Eigen::Vector2d displacement_px;
  double radius_px = 1;
};

/// A parametric model with local bumps. Ground truth for tests; its parameters
/// cannot be optimized.
class SimulatedCamera : public CameraModel {
 public:
  /// |displacement| / radius must be well below 1 in total, or the image folds.
  SimulatedCamera(const OpenCvModel& lens, std::vector<DistortionBump> bumps);
  /// The lens must be defined wherever the bumps map the area's pixels to.
  SimulatedCamera(std::shared_ptr<const CameraModel> lens, const Area& area,
                  std::vector<DistortionBump> bumps);

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
  // Returns the displacement by the bumps; *derivative is its pixel Jacobian.
  Eigen::Vector2d ApplyDistortionBumps(const Eigen::Vector2d& pixel,
                                       Eigen::Matrix2d* derivative) const;

  std::shared_ptr<const CameraModel> lens_;
  std::vector<DistortionBump> bumps_;
};

/// Returns a 640 x 480 camera with a horizontal field of view of about 62
/// degrees, barrel distortion, and bumps of up to 1.5 px.
SimulatedCamera ExampleSimulatedCamera();

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_SIMULATED_CAMERA_H
