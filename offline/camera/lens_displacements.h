#ifndef RAYGRID_CAMERA_LENS_DISPLACEMENTS_H
#define RAYGRID_CAMERA_LENS_DISPLACEMENTS_H

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "camera/camera_model.h"

namespace raygrid {

/// A value of each pixel of a list; nothing of what is not seen.
using PixelField = std::vector<std::optional<Eigen::Vector2d>>;

/// How far a unit's pixels look beside a reference's, in the reference's pixels
/// and without what a turn of the camera does. Nothing of what lies more than
/// kDisplacementMarginPx beyond the reference's area.
PixelField ComputeDisplacements(const CameraModel& reference,
                                const CameraModel& unit,
                                const std::vector<Eigen::Vector2d>& pixels);

constexpr double kDisplacementMarginPx = 50;

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_LENS_DISPLACEMENTS_H
