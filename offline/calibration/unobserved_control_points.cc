#include "calibration/unobserved_control_points.h"

#include <cmath>
#include <vector>

#include "camera/bspline_surface.h"

namespace raygrid {
namespace {

// Marks the control points that influence at least one feature.
std::vector<bool> FindObservedControlPoints(const CalibrationProblem& problem,
                                            int camera_index,
                                            const BSplineSurface& grid) {
  std::vector<bool> is_observed(grid.num_points(), false);
  for (const View& view : problem.views) {
    if (view.camera != camera_index) continue;
    for (const Observation& observation : view.observations) {
      const SplineSupport support = grid.Support(observation.pixel);
      for (int row = support.row; row < support.row + 4; ++row)
        for (int column = support.column; column < support.column + 4; ++column)
          is_observed[row * grid.columns() + column] = true;
    }
  }
  return is_observed;
}

}  // namespace

void LimitUnobservedControlPoints(const CalibrationProblem& problem,
                                  int camera_index, CameraModel* camera) {
  const double max_plane_radius = std::tan(150 * M_PI / 180 / 2);
  const BSplineSurface* grid = camera->DirectionGrid();
  if (!grid) return;
  const std::vector<bool> is_observed =
      FindObservedControlPoints(problem, camera_index, *grid);
  Eigen::VectorXd parameters = camera->Parameters();
  const Eigen::Index per_node = parameters.size() / grid->num_points();
  for (int k = 0; k < grid->num_points(); ++k) {
    auto chart = parameters.segment<2>(per_node * k);
    if (!is_observed[k] && chart.norm() > max_plane_radius)
      chart *= max_plane_radius / chart.norm();
  }
  camera->SetParameters(parameters);
}

}  // namespace raygrid
