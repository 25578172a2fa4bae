#include "host_library/start_table.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "camera/stereographic.h"

namespace raygrid {
namespace {

constexpr int kCellsAlong = 64;  // at most 36 KB

// Directions of the area in chart coordinates.
Eigen::AlignedBox2d ChartBounds(const CentralGeneric& camera) {
  constexpr int kPerCell = 3;
  Eigen::AlignedBox2d bounds;
  for (const Eigen::Vector2d& pixel : camera.surface().SamplePixels(kPerCell))
    bounds.extend(camera.surface().Evaluate(pixel));
  return bounds;
}

}  // namespace

StartTable::StartTable(const CentralGeneric& camera) {
  const Eigen::AlignedBox2d bounds = ChartBounds(camera);
  const double cell = std::max(bounds.sizes().maxCoeff() / kCellsAlong, 1e-9);
  // One more node on each side: pixels near the edge have four nodes.
  const Eigen::Vector2d first = bounds.min().array() - cell;
  columns_ = static_cast<int>(std::ceil(bounds.sizes().x() / cell)) + 3;
  const int rows = static_cast<int>(std::ceil(bounds.sizes().y() / cell)) + 3;
  first_ = first.cast<float>();
  cells_.setConstant(static_cast<float>(1 / cell));
  last_column_ = static_cast<float>(columns_ - 1);
  last_row_ = static_cast<float>(rows - 1);
  const Area& area = camera.area();
  const double margin_px =
      2 * std::max(area.width(), area.height()) / kCellsAlong;
  for (int j = 0; j < rows; ++j) {
    std::optional<Eigen::Vector2d> start;
    for (int i = 0; i < columns_; ++i) {
      const Eigen::Vector3d direction =
          FromChart(first + cell * Eigen::Vector2d(i, j));
      auto pixel =
          start ? camera.Project(direction, &*start, margin_px) : std::nullopt;
      if (!pixel) pixel = camera.Project(direction, nullptr, margin_px);
      start = pixel;
      for (int k = 0; k < 2; ++k)
        pixels_.push_back(pixel ? static_cast<float>((*pixel)[k])
                                : std::numeric_limits<float>::quiet_NaN());
    }
  }
}

}  // namespace raygrid
