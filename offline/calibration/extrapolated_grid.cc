#include "calibration/extrapolated_grid.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "camera/stereographic.h"

namespace raygrid {
namespace {

constexpr double kMaxAngleRad = 2.28;

double AngleFromAxis(const Eigen::Vector3d& ray) {
  return std::atan2(ray.head<2>().norm(), ray.z());
}

// Extrapolates the radial projection curve of a lens beyond its valid angle of
// incidence.
class RadialContinuation {
 public:
  explicit RadialContinuation(const CameraModel& lens)
      : lens_(lens), center_(lens.Project({0, 0, 1})) {}

  std::optional<Eigen::Vector3d> Direction(const Eigen::Vector2d& pixel) const {
    if (!center_) return std::nullopt;
    const Eigen::Vector2d side = pixel - *center_;
    // Largest valid angle of incidence on this side of the image.
    double end = kMaxAngleRad;
    while (end > kStep && !ComputeRadiusPx(end, side)) end -= kStep;
    const auto radius = ComputeRadiusPx(end, side);
    const auto before = ComputeRadiusPx(end - kStep, side);
    if (!radius || !before || !(*radius > *before) || side.norm() < *radius)
      return std::nullopt;
    // The slope tends to infinity near a fold of the projection.
    const double slope =
        std::min(kStep / (*radius - *before), kMaxSlope * end / *radius);
    const double remaining_angle_rad = kMaxContinuedAngleRad - end;
    const double linear_extrapolation = slope * (side.norm() - *radius);
    return At(end - remaining_angle_rad *
                        std::expm1(-linear_extrapolation / remaining_angle_rad),
              side);
  }

 private:
  static constexpr double kStep = 0.02,
                          kMaxContinuedAngleRad = kMaxAngleRad + kStep;
  static constexpr double kMaxSlope = 2;  // relative to the mean slope

  // Returns the direction at an angle from the optical axis, towards an image
  // offset from the centre.
  static Eigen::Vector3d At(double angle_rad, const Eigen::Vector2d& side) {
    const Eigen::Vector2d across = std::sin(angle_rad) * side.normalized();
    return {across.x(), across.y(), std::cos(angle_rad)};
  }

  // Returns the distance in pixels of that direction's projection from the
  // centre.
  std::optional<double> ComputeRadiusPx(double angle_rad,
                                        const Eigen::Vector2d& side) const {
    constexpr double kUnlimitedMarginPx = 1e9;
    const auto pixel =
        lens_.Project(At(angle_rad, side), nullptr, kUnlimitedMarginPx);
    if (!pixel) return std::nullopt;
    return (*pixel - *center_).norm();
  }

  const CameraModel& lens_;
  std::optional<Eigen::Vector2d> center_;
};

}  // namespace

CentralGeneric FitExtrapolatedGrid(const CameraModel& lens, const Area& area,
                                   int columns, int rows) {
  constexpr int kSamplesPerCell = 4;
  constexpr double kContinuedWeight = 1e-4;
  const RadialContinuation continuation(lens);
  std::vector<SurfaceSample> samples;
  for (const Eigen::Vector2d& pixel :
       BSplineSurface(area, columns, rows).SamplePixels(kSamplesPerCell)) {
    const auto ray = lens.Unproject(pixel);
    if (ray && AngleFromAxis(*ray) <= kMaxAngleRad)
      samples.push_back({pixel, ToChart(*ray)});
    else if (const auto continued = continuation.Direction(pixel))
      samples.push_back({pixel, ToChart(*continued), kContinuedWeight});
  }
  return CentralGeneric(lens.image_size(),
                        FitSurface(area, columns, rows, samples));
}

}  // namespace raygrid
