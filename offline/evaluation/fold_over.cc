#include "evaluation/fold_over.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

namespace raygrid {
namespace {

constexpr double kCellPx = 8;
constexpr double kMaxCells = 20000;

// Returns the centres of the area's cells in row-major order.
std::vector<Eigen::Vector2d> GetCellCenters(const Area& area) {
  const double knot_spacing_px =
      std::max(kCellPx, std::sqrt(area.width() * area.height() / kMaxCells));
  const auto count = [knot_spacing_px](double extent) {
    return std::max(1, static_cast<int>(std::lround(extent / knot_spacing_px)));
  };
  const int columns = count(area.width()), rows = count(area.height());
  std::vector<Eigen::Vector2d> centers;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      centers.emplace_back(area.x0 + (i + 0.5) / columns * area.width(),
                           area.y0 + (j + 0.5) / rows * area.height());
  return centers;
}

// Returns the sign of the determinant of a pixel's ray and its derivatives: +1
// or -1, or 0 if the pixel has no ray.
int ComputeHandedness(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  constexpr double kStepPx = 0.25;
  const auto here = camera.Unproject(pixel);
  const auto right = camera.Unproject(pixel + Eigen::Vector2d(kStepPx, 0));
  const auto below = camera.Unproject(pixel + Eigen::Vector2d(0, kStepPx));
  if (!here || !right || !below) return 0;
  return here->dot((*right - *here).cross(*below - *here)) < 0 ? -1 : 1;
}

}  // namespace

FoldOver MeasureFoldOver(const CameraModel& camera,
                         const ValidityMask* valid_region) {
  const std::vector<Eigen::Vector2d> centers = GetCellCenters(camera.area());
  std::vector<int> handedness;
  int sum = 0;
  for (const Eigen::Vector2d& center : centers)
    sum += handedness.emplace_back(ComputeHandedness(camera, center));
  int folded = 0, folded_valid = 0;
  for (size_t i = 0; i < centers.size(); ++i) {
    if (handedness[i] * sum >= 0) continue;
    ++folded;
    folded_valid += valid_region && valid_region->IsValidAt(centers[i]);
  }
  const double count = static_cast<double>(centers.size());
  return {folded / count, folded_valid / count};
}

}  // namespace raygrid
