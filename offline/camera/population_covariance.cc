#include "camera/population_covariance.h"

namespace raygrid {

std::vector<Eigen::Vector2d> PopulationCovariance::GetPositions(
    const Area& area) const {
  std::vector<Eigen::Vector2d> positions;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      positions.emplace_back(area.x0 + area.width() * i / (columns - 1),
                             area.y0 + area.height() * j / (rows - 1));
  return positions;
}

std::vector<BSplineSurface> PopulationCovariance::FitSurfaces(
    const Area& area) const {
  const std::vector<Eigen::Vector2d> positions = GetPositions(area);
  std::vector<BSplineSurface> surfaces;
  for (const std::vector<Eigen::Vector2d>& field : displacements_px) {
    std::vector<SurfaceSample> samples;
    for (size_t i = 0; i < positions.size(); ++i)
      samples.push_back({positions[i], field[i]});
    surfaces.push_back(FitSurface(area, columns, rows, samples));
  }
  return surfaces;
}

}  // namespace raygrid
