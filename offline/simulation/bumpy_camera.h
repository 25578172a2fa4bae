#ifndef RAYGRID_SIMULATION_BUMPY_CAMERA_H
#define RAYGRID_SIMULATION_BUMPY_CAMERA_H

#include <cstdint>
#include <memory>
#include <vector>

#include "camera/opencv.h"
#include "simulation/noncentral_simulated_camera.h"

namespace raygrid {

/// Parameters of bumps distributed over an image.
struct BumpySurface {
  double width_px = 20;      ///< at half height
  double height_px = 0.2;    ///< maximum displacement (px), in any direction
  double pupil_shift_m = 0;  ///< see MovingPupilCamera
  uint64_t seed = 0;
};

/// A parametric lens with a Gaussian bump in each square of a lattice with a
/// spacing of two widths, within half a width of the square's centre. Ground
/// truth; its parameters cannot be optimized.
class BumpyCamera : public NoncentralSimulatedCamera {
 public:
  /// lens: must be defined up to the height of the bumps outside the area.
  BumpyCamera(const OpenCvModel& lens, const Area& area,
              const BumpySurface& surface);

  std::string Name() const override { return "bumpy"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<BumpyCamera>(*this);
  }
  std::optional<ObservationLine> Line(
      const Eigen::Vector2d& pixel) const override;
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* start,
                                         double margin_px) const override;
  using CameraModel::Project;

  /// Returns the displacement of a pixel by the bumps, relative to the lens.
  Eigen::Vector2d ComputeShift(const Eigen::Vector2d& pixel) const;

 private:
  struct Bump {
    Eigen::Vector2d center, shift_px;
  };

  OpenCvModel lens_;
  BumpySurface surface_;
  int columns_ = 0, rows_ = 0;
  std::vector<Bump> bumps_;  // one per square
};

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_BUMPY_CAMERA_H
