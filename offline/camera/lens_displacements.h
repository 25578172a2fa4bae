#ifndef RAYGRID_CAMERA_LENS_DISPLACEMENTS_H
#define RAYGRID_CAMERA_LENS_DISPLACEMENTS_H

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "camera/camera_model.h"

namespace raygrid {

/// A value for each pixel of a list; nullopt if undefined.
using PixelField = std::vector<std::optional<Eigen::Vector2d>>;

/// Computes how a unit's pixels are displaced in a reference camera, after the
/// best rotation, in the reference's pixels. nullopt for pixels without a
/// direction or more than kDisplacementMarginPx outside the reference's area.
PixelField ComputeDisplacements(const CameraModel& reference,
                                const CameraModel& unit,
                                const std::vector<Eigen::Vector2d>& pixels);

constexpr double kDisplacementMarginPx = 50;

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_LENS_DISPLACEMENTS_H
