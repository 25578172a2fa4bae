#include "packing/virtual_camera.h"

#include <fmt/format.h>

#include <Eigen/LU>
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

}  // namespace raygrid
