#ifndef RAYGRID_SIMULATION_BUMPY_LENS_H
#define RAYGRID_SIMULATION_BUMPY_LENS_H

#include <cstdint>
#include <memory>
#include <vector>

#include "camera/opencv.h"
#include "simulation/line_lens.h"

namespace raygrid {

/// Small bumps all over an image.
struct BumpySurface {
  double width_px = 20;      ///< at half their height
  double height_px = 0.2;    ///< by so much they move a pixel, anywhere to
  double pupil_shift_m = 0;  ///< as MovingPupilLens
  uint64_t seed = 0;
};

/// A lens by a formula whose image has a Gaussian bump in each square of a
/// lattice, two widths wide: around the square's middle, half a width off at
/// most. Its parameters cannot be adjusted.
class BumpyLens : public LineLens {
 public:
  /// lens: over more than the area, by the bumps' height at least.
  BumpyLens(const OpenCvModel& lens, const Area& area,
            const BumpySurface& surface);

  std::string Name() const override { return "bumpy"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<BumpyLens>(*this);
  }
  std::optional<ObservationLine> Line(
      const Eigen::Vector2d& pixel) const override;
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* start,
                                         double margin_px) const override;
  using CameraModel::Project;

  /// How far the bumps move what the lens by itself sees at a pixel.
  Eigen::Vector2d Shift(const Eigen::Vector2d& pixel) const;

 private:
  struct Bump {
    Eigen::Vector2d center, shift_px;
  };

  OpenCvModel lens_;
  BumpySurface surface_;
  int columns_ = 0, rows_ = 0;
  std::vector<Bump> bumps_;  // a square each
};

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_BUMPY_LENS_H
