/// Newton's method for the pixel that shows a point (paper, "Projection").
#ifndef RAYGRID_CAMERA_PIXEL_SEARCH_H
#define RAYGRID_CAMERA_PIXEL_SEARCH_H

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "camera/area.h"

namespace raygrid {

/// The pixel where an error vanishes, and minus the error's derivative there.
struct PixelSolution {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d derivative;
};

inline Eigen::Vector2d ClampToArea(const Eigen::Vector2d& pixel,
                                   const Area& area, double margin_px) {
  return {std::clamp(pixel.x(), area.x0 - margin_px, area.x1 + margin_px),
          std::clamp(pixel.y(), area.y0 - margin_px, area.y1 + margin_px)};
}

/// Newton's method with step halving, within the area. error(pixel, derivative)
/// gives the error and minus its derivative by the pixel.
template <typename Error>
std::optional<PixelSolution> FindPixel(const Area& area,
                                       const Eigen::Vector2d& start,
                                       double margin_px, const Error& error) {
  constexpr int kMaxIterations = 50;
  constexpr double kConvergedPx = 1e-9, kAcceptedPx = 1e-6;
  PixelSolution at;
  at.pixel = ClampToArea(start, area, margin_px);
  Eigen::Vector2d error_here = error(at.pixel, &at.derivative);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const double determinant = at.derivative.determinant();
    if (!(std::abs(determinant) > 1e-30)) return std::nullopt;
    const Eigen::Vector2d newton = at.derivative.inverse() * error_here;
    if (newton.norm() < kConvergedPx) return at;

    bool improved = false;
    for (double length = 1; length > 1e-3 && !improved; length /= 2) {
      PixelSolution next;
      next.pixel = ClampToArea(at.pixel + length * newton, area, margin_px);
      const Eigen::Vector2d next_error = error(next.pixel, &next.derivative);
      if (!(next_error.squaredNorm() < error_here.squaredNorm())) continue;
      improved = true;
      at = next;
      error_here = next_error;
    }
    // No decrease: converged as far as rounding allows, or stuck at the edge.
    if (!improved)
      return newton.norm() < kAcceptedPx ? std::optional(at) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PIXEL_SEARCH_H
