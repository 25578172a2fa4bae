#ifndef RAYGRID_FLEET_LENS_DISPLACEMENTS_H
#define RAYGRID_FLEET_LENS_DISPLACEMENTS_H

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "camera/area.h"
#include "camera/camera_model.h"

namespace raygrid {

/// A value of each pixel of a list; nothing of what is not seen.
using PixelField = std::vector<std::optional<Eigen::Vector2d>>;

/// How far a unit's pixels look beside a reference's, in the reference's pixels
/// and without what a turn of the camera does.
PixelField DisplacementsOf(const CameraModel& reference,
                           const CameraModel& unit,
                           const std::vector<Eigen::Vector2d>& pixels);

/// How many PolynomialsAt() has of a degree.
constexpr int NumPolynomials(int degree) {
  return (degree + 1) * (degree + 2) / 2;
}

/// Products of Legendre polynomials of a pixel's place in an area, up to a
/// degree: 1, x, y, x^2, ...; each from -1 to 1.
Eigen::VectorXd PolynomialsAt(const Area& area, const Eigen::Vector2d& pixel,
                              int degree);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_LENS_DISPLACEMENTS_H
