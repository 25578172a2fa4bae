#include "packing/virtual_camera.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "dataset/error.h"

namespace raygrid {
namespace {

constexpr double kMaxFieldOfViewDeg = 170;
// Blobs hold focal lengths in q16.
constexpr double kMaxFocalPx = 65535;

// Pixels per radian where the camera looks straight ahead, or else in the
// middle of its area.
double CentralFocalLength(const CameraModel& camera) {
  LinearizedProjection projection;
  const Eigen::Vector3d forward(0, 0, 1);
  if (!camera.Linearize(forward, nullptr, 0, &projection)) {
    const auto ray = camera.Unproject(camera.area().center());
    if (!ray || !camera.Linearize(*ray, nullptr, 0, &projection))
      return camera.image_size().width;
  }
  // The two singular values' geometric mean.
  const Eigen::Matrix2d product =
      projection.by_point * projection.by_point.transpose();
  return std::pow(product.determinant(), 0.25);
}

// The box in which a pinhole image of focal length 1 shows the area, as far as
// it does.
Eigen::AlignedBox2d ImageOfArea(const CameraModel& camera) {
  constexpr int kSteps = 32;
  const double least_z = std::cos(70 * M_PI / 180);
  Eigen::AlignedBox2d box;
  const Area& area = camera.area();
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const auto ray = camera.Unproject({area.x0 + area.width() * i / kSteps,
                                         area.y0 + area.height() * j / kSteps});
      if (ray && ray->z() > least_z)
        box.extend(Eigen::Vector2d(ray->head<2>() / ray->z()));
    }
  }
  return box;
}

}  // namespace

double VirtualCamera::HorizontalFieldOfViewDeg() const {
  return 2 * std::atan(size.width / 2.0 / focal_px) * 180 / M_PI;
}

VirtualCamera MakeVirtualCamera(const CameraModel& camera, ImageSize size,
                                double hfov_deg) {
  if (size.width == 0) size = camera.image_size();
  VirtualCamera result;
  result.size = size;
  result.center = {(size.width - 1) / 2.0, (size.height - 1) / 2.0};
  if (hfov_deg == 0) {
    result.focal_px =
        CentralFocalLength(camera) * size.width / camera.image_size().width;
  } else if (hfov_deg > 0 && hfov_deg <= kMaxFieldOfViewDeg) {
    result.focal_px = size.width / 2.0 / std::tan(hfov_deg * M_PI / 360);
  } else {
    throw Error(ExitCode::kUsage,
                fmt::format("a field of view of {} degrees: a pinhole image "
                            "has more than 0 and at most {}",
                            hfov_deg, kMaxFieldOfViewDeg));
  }
  if (result.focal_px > kMaxFocalPx)
    throw Error(
        ExitCode::kUsage,
        fmt::format(
            "a focal length of {:.0f} px for {} px of width: a blob "
            "holds at most {}; ask for a field of view of at least "
            "{:.3g} degrees, or for fewer pixels",
            result.focal_px, size.width, kMaxFocalPx,
            std::atan(size.width / 2.0 / kMaxFocalPx) * 360 / M_PI + 0.001));
  return result;
}

VirtualCamera MakeVirtualCameraOfArea(const CameraModel& camera) {
  // Blobs hold centres in q16, too.
  constexpr double kMaxCenterPx = 32767;
  const Eigen::AlignedBox2d seen = ImageOfArea(camera);
  VirtualCamera result;
  result.size = camera.image_size();
  const Eigen::Vector2d size(result.size.width, result.size.height);
  if (!seen.isEmpty()) {
    result.focal_px = (size.array() / seen.sizes().array()).minCoeff();
    result.center =
        (size.array() - 1).matrix() / 2 - result.focal_px * seen.center();
  }
  if (seen.isEmpty() || !(result.focal_px <= kMaxFocalPx) ||
      !(result.center.cwiseAbs().maxCoeff() <= kMaxCenterPx))
    throw Error(ExitCode::kQuality,
                "no pinhole image shows the calibrated area");
  return result;
}

}  // namespace raygrid
