#ifndef RAYGRID_SIMULATION_SIMULATED_FISHEYE_H
#define RAYGRID_SIMULATION_SIMULATED_FISHEYE_H

#include <cmath>
#include <memory>

#include "camera/camera_model.h"

namespace raygrid {

/// A fisheye: a direction at the angle theta from the z axis is projected to
/// the distance r = f (theta + k1 theta^3 + k2 theta^5) from (cx, cy).
struct FisheyeParameters {
  double f_px = 0, cx = 0, cy = 0;
  double k1 = 0, k2 = 0;
  /// Edge of the image circle, up to which r must increase monotonically.
  double max_theta = 100 * M_PI / 180;

  double Radius(double theta) const {
    const double t2 = theta * theta;
    return f_px * theta * (1 + t2 * (k1 + t2 * k2));
  }
  double RadiusDerivative(double theta) const {
    const double t2 = theta * theta;
    return f_px * (1 + t2 * (3 * k1 + t2 * 5 * k2));
  }
};

/// Ground truth with this model; its parameters cannot be optimized.
class SimulatedFisheye : public CameraModel {
 public:
  SimulatedFisheye(const ImageSize& size, const Area& area,
                   const FisheyeParameters& parameters)
      : CameraModel(size, area), parameters_(parameters) {}

  std::string Name() const override { return "fisheye"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<SimulatedFisheye>(*this);
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
  FisheyeParameters parameters_;
};

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_SIMULATED_FISHEYE_H
