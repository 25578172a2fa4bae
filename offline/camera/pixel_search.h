/// Projection by Newton's method: the pixel of a point (paper, "Projection").
#ifndef RAYGRID_CAMERA_PIXEL_SEARCH_H
#define RAYGRID_CAMERA_PIXEL_SEARCH_H

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "camera/area.h"

namespace raygrid {

/// The root of an error function, and minus the error's derivative there.
struct PixelSolution {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d derivative;
};

/// The unfolded side of a surface. A lens does not mirror, so the surface is
/// folded where its handedness is reversed. After a second fold, the handedness
/// is the original one again; short steps from the centre do not lead there.
struct UnfoldedSide {
  int handedness = 0;  ///< +1 or -1; 0 if there are no folds
  /// Maximum step of a search, short enough not to cross a fold.
  double max_step_px = std::numeric_limits<double>::infinity();

  bool folds() const { return handedness != 0; }
  /// derivative: Jacobian of the surface, or of minus the error.
  bool IsFolded(const Eigen::Matrix2d& derivative) const {
    return folds() && !(derivative.determinant() * handedness > 0);
  }
};

inline Eigen::Vector2d ClampToArea(const Eigen::Vector2d& pixel,
                                   const Area& area, double margin_px) {
  return {std::clamp(pixel.x(), area.x0 - margin_px, area.x1 + margin_px),
          std::clamp(pixel.y(), area.y0 - margin_px, area.y1 + margin_px)};
}

/// Newton's method with step halving, within the area. error(pixel, derivative)
/// returns the error, and minus its derivative with respect to the pixel. If a
/// surface is folded, the search stays on its unfolded side.
template <typename Error>
std::optional<PixelSolution> FindPixel(const Area& area,
                                       const Eigen::Vector2d& start,
                                       double margin_px, const Error& error,
                                       const UnfoldedSide& side = {}) {
  constexpr int kMaxIterations = 50, kMaxHalvings = 10;
  constexpr double kConvergedPx = 1e-9, kAcceptedPx = 1e-6;
  PixelSolution at;
  at.pixel = ClampToArea(start, area, margin_px);
  Eigen::Vector2d error_here = error(at.pixel, &at.derivative);
  if (side.IsFolded(at.derivative)) return std::nullopt;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const double determinant = at.derivative.determinant();
    if (!(std::abs(determinant) > 1e-30)) return std::nullopt;
    const Eigen::Vector2d newton = at.derivative.inverse() * error_here;
    const double newton_step_px = newton.norm();
    if (newton_step_px < kConvergedPx) return at;

    bool improved = false;
    double length = std::min(1.0, side.max_step_px / newton_step_px);
    for (int k = 0; k < kMaxHalvings && !improved; ++k, length /= 2) {
      PixelSolution next;
      next.pixel = ClampToArea(at.pixel + length * newton, area, margin_px);
      const Eigen::Vector2d next_error = error(next.pixel, &next.derivative);
      if (!(next_error.squaredNorm() < error_here.squaredNorm()) ||
          side.IsFolded(next.derivative))
        continue;
      improved = true;
      at = next;
      error_here = next_error;
    }
    // No decrease: converged within rounding, or stuck at the edge.
    if (!improved)
      return newton_step_px < kAcceptedPx ? std::optional(at) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PIXEL_SEARCH_H
