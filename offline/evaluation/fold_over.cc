#include "evaluation/fold_over.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

namespace raygrid {
namespace {

constexpr double kCellPx = 8;
constexpr double kMaxCells = 20000;

// The centres of the area's cells, row by row.
std::vector<Eigen::Vector2d> CellMiddles(const Area& area) {
  const double knot_spacing_px =
      std::max(kCellPx, std::sqrt(area.width() * area.height() / kMaxCells));
  const auto count = [knot_spacing_px](double extent) {
    return std::max(1, static_cast<int>(std::lround(extent / knot_spacing_px)));
  };
  const int columns = count(area.width()), rows = count(area.height());
  std::vector<Eigen::Vector2d> middles;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      middles.emplace_back(area.x0 + (i + 0.5) / columns * area.width(),
                           area.y0 + (j + 0.5) / rows * area.height());
  return middles;
}

// The sign of the determinant of a pixel's ray and its derivatives: +1 or -1,
// or 0 without a ray.
int Handedness(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  constexpr double kStepPx = 0.25;
  const auto here = camera.Unproject(pixel);
  const auto right = camera.Unproject(pixel + Eigen::Vector2d(kStepPx, 0));
  const auto below = camera.Unproject(pixel + Eigen::Vector2d(0, kStepPx));
  if (!here || !right || !below) return 0;
  return here->dot((*right - *here).cross(*below - *here)) < 0 ? -1 : 1;
}

}  // namespace

FoldOver MeasureFoldOver(const CameraModel& camera,
                         const ValidityMask* trusted) {
  const std::vector<Eigen::Vector2d> middles = CellMiddles(camera.area());
  std::vector<int> handedness;
  int sum = 0;
  for (const Eigen::Vector2d& middle : middles)
    sum += handedness.emplace_back(Handedness(camera, middle));
  int folded = 0, folded_trusted = 0;
  for (size_t i = 0; i < middles.size(); ++i) {
    if (handedness[i] * sum >= 0) continue;
    ++folded;
    folded_trusted += trusted && trusted->IsValidAt(middles[i]);
  }
  const double count = static_cast<double>(middles.size());
  return {folded / count, folded_trusted / count};
}

}  // namespace raygrid
