#include "simulation/bumpy_camera.h"

#include <algorithm>
#include <cmath>

#include "simulation/random.h"

namespace raygrid {
namespace {

constexpr int kMaxIterations = 50;
constexpr double kConvergedPx = 1e-11, kConvergedM = 1e-15;
const double kWidthPerStdDev = 2 * std::sqrt(2 * std::log(2));

double ComputeSquaredAngle(const Eigen::Vector3d& direction) {
  const double theta = std::atan2(direction.head<2>().norm(), direction.z());
  return theta * theta;
}

}  // namespace

BumpyCamera::BumpyCamera(const OpenCvModel& lens, const Area& area,
                         const BumpySurface& surface)
    : NoncentralSimulatedCamera(lens.image_size(), area),
      lens_(lens),
      surface_(surface) {
  const double side = 2 * surface.width_px;
  columns_ = static_cast<int>(std::ceil(area.width() / side)) + 1;
  rows_ = static_cast<int>(std::ceil(area.height() / side)) + 1;
  Random random(surface.seed);
  for (int row = 0; row < rows_; ++row)
    for (int column = 0; column < columns_; ++column) {
      const double x = column + 0.5 + random.Uniform(-0.25, 0.25);
      const double y = row + 0.5 + random.Uniform(-0.25, 0.25);
      const double angle = random.Uniform(0, 2 * M_PI);
      bumps_.push_back(
          {Eigen::Vector2d(area.x0, area.y0) + side * Eigen::Vector2d(x, y),
           surface.height_px *
               Eigen::Vector2d(std::cos(angle), std::sin(angle))});
    }
}

// Bumps at least two squares away are omitted: they are at a distance of at
// least 5.9 standard deviations.
Eigen::Vector2d BumpyCamera::ComputeShift(const Eigen::Vector2d& pixel) const {
  const double side = 2 * surface_.width_px;
  const double deviation = surface_.width_px / kWidthPerStdDev;
  const int column =
      static_cast<int>(std::floor((pixel.x() - area().x0) / side));
  const int row = static_cast<int>(std::floor((pixel.y() - area().y0) / side));
  Eigen::Vector2d shift(0, 0);
  for (int y = std::max(0, row - 1); y <= std::min(rows_ - 1, row + 1); ++y)
    for (int x = std::max(0, column - 1);
         x <= std::min(columns_ - 1, column + 1); ++x) {
      const Bump& bump = bumps_[y * columns_ + x];
      shift += bump.shift_px * std::exp(-(pixel - bump.center).squaredNorm() /
                                        (2 * deviation * deviation));
    }
  return shift;
}

std::optional<ObservationLine> BumpyCamera::Line(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  const auto direction = lens_.Unproject(pixel + ComputeShift(pixel));
  if (!direction) return std::nullopt;
  const double depth_m =
      surface_.pupil_shift_m * ComputeSquaredAngle(*direction);
  return ObservationLine{{0, 0, depth_m}, *direction};
}

// Fixed-point iteration, because pupil and bumps only cause small
// displacements.
std::optional<Eigen::Vector2d> BumpyCamera::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* /*start*/,
    double margin_px) const {
  Eigen::Vector3d from_pupil = point;
  for (int i = 0; i < kMaxIterations; ++i) {
    const double depth_m =
        surface_.pupil_shift_m * ComputeSquaredAngle(from_pupil);
    const double change = point.z() - depth_m - from_pupil.z();
    from_pupil.z() += change;
    if (std::abs(change) < kConvergedM) break;
  }
  const auto straight = lens_.Project(from_pupil);
  if (!straight) return std::nullopt;
  Eigen::Vector2d pixel = *straight;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Eigen::Vector2d next = *straight - ComputeShift(pixel);
    const double change = (next - pixel).norm();
    pixel = next;
    if (change < kConvergedPx) break;
  }
  if (!area().Contains(pixel, margin_px)) return std::nullopt;
  return pixel;
}

}  // namespace raygrid
