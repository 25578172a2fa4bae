#ifndef RAYGRID_SIMULATION_NONCENTRAL_SIMULATED_CAMERA_H
#define RAYGRID_SIMULATION_NONCENTRAL_SIMULATED_CAMERA_H

#include <memory>

#include "camera/camera_model.h"

namespace raygrid {

/// Ground truth with observation lines that do not intersect: subclasses define
/// Line(). Projection searches for the line through a point. Its parameters
/// cannot be optimized.
class NoncentralSimulatedCamera : public CameraModel {
 public:
  bool IsCentral() const override { return false; }
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

 protected:
  NoncentralSimulatedCamera(const ImageSize& size, const Area& area)
      : CameraModel(size, area) {}
};

/// A lens whose entrance pupil moves forward by theta^2, with theta the angle
/// from the axis.
class MovingPupilCamera : public NoncentralSimulatedCamera {
 public:
  /// shift_m: the displacement of the pupil at 1 radian.
  MovingPupilCamera(const CameraModel& lens, double shift_m)
      : NoncentralSimulatedCamera(lens.image_size(), lens.area()),
        lens_(lens.Clone()),
        shift_m_(shift_m) {}

  std::string Name() const override { return "moving-pupil"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<MovingPupilCamera>(*this);
  }
  std::optional<ObservationLine> Line(
      const Eigen::Vector2d& pixel) const override;

 private:
  std::shared_ptr<const CameraModel> lens_;
  double shift_m_;
};

/// A plane-parallel plate, in metres: its first face passes through (0, 0,
/// distance_m), its normal is rotated from the z axis towards x.
struct GlassPlate {
  double thickness_m = 0.005, refractive_index = 1.5;
  double tilt_rad = M_PI / 6, distance_m = 0.02;
};

/// A lens behind a glass plate, by Snell's law at both faces. The plate does
/// not change directions, but displaces lines, more at oblique incidence. A
/// line starts where it leaves the plate.
class CoverGlassCamera : public NoncentralSimulatedCamera {
 public:
  CoverGlassCamera(const CameraModel& lens, const GlassPlate& plate)
      : NoncentralSimulatedCamera(lens.image_size(), lens.area()),
        lens_(lens.Clone()),
        plate_(plate) {}

  std::string Name() const override { return "glass"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<CoverGlassCamera>(*this);
  }
  std::optional<ObservationLine> Line(
      const Eigen::Vector2d& pixel) const override;

 private:
  std::shared_ptr<const CameraModel> lens_;
  GlassPlate plate_;
};

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_NONCENTRAL_SIMULATED_CAMERA_H
