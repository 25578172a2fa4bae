#include "camera/lens_displacements.h"

#include "camera/nearest_rotation.h"
#include "camera/rotated_camera.h"

namespace raygrid {

PixelField ComputeDisplacements(const CameraModel& reference,
                                const CameraModel& unit,
                                const std::vector<Eigen::Vector2d>& pixels) {
  const RotatedCamera rotated(
      unit, ComputeNearestRotation(reference, unit, reference.area()));
  PixelField values;
  for (const Eigen::Vector2d& pixel : pixels) {
    const auto ray = rotated.Unproject(pixel);
    const auto projected =
        ray ? reference.Project(*ray, &pixel, kDisplacementMarginPx)
            : std::nullopt;
    values.push_back(projected
                         ? std::optional<Eigen::Vector2d>(*projected - pixel)
                         : std::nullopt);
  }
  return values;
}

}  // namespace raygrid
