#include "packing/projection_error.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "camera/central_generic.h"
#include "camera/stereographic.h"
#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

// Returns the two ends of a side of the area, and the integer positions between
// them with this step.
std::vector<double> Positions(double from, double to, int step) {
  std::vector<double> positions = {from};
  for (double x = std::ceil(from); x < to; x += step)
    if (x > from) positions.push_back(x);
  positions.push_back(to);
  return positions;
}

void Add(const ProjectedPixels& more, ProjectedPixels* sum) {
  sum->num_pixels += more.num_pixels;
  sum->num_not_invertible += more.num_not_invertible;
  sum->num_not_converged += more.num_not_converged;
  sum->num_inaccurate += more.num_inaccurate;
  sum->worst_px = std::max(sum->worst_px, more.worst_px);
}

}  // namespace

ProjectionError MeasureProjection(const BlobCamera& blob,
                                  const ValidityMask* valid_region,
                                  double max_pixels, int num_threads) {
  const std::unique_ptr<CameraModel> model = blob.ToModel();
  const BSplineSurface& surface = *model->DirectionGrid();
  const Area& area = surface.area();
  const int handedness = ComputeDominantHandedness(surface);
  const int step = static_cast<int>(
      std::ceil(std::sqrt(area.width() * area.height() / max_pixels)));
  const std::vector<double> columns = Positions(area.x0, area.x1, step);
  const std::vector<double> rows = Positions(area.y0, area.y1, step);
  std::vector<ProjectionError> errors(rows.size());
  ParallelFor(static_cast<int>(rows.size()), num_threads, [&](int j) {
    for (const double x : columns) {
      const Eigen::Vector2d pixel(x, rows[j]);
      ProjectedPixels& found = !valid_region || valid_region->IsValidAt(pixel)
                                   ? errors[j].valid_region
                                   : errors[j].others;
      Eigen::Matrix2d derivative;
      const Eigen::Vector2d chart = surface.Evaluate(pixel, &derivative);
      if (derivative.determinant() * handedness <= 0 ||
          chart.norm() > kMaxChartRadius) {
        ++found.num_not_invertible;
        continue;
      }
      ++found.num_pixels;
      const auto back = blob.Project(FromChart(chart));
      if (!back) {
        ++found.num_not_converged;
        continue;
      }
      const double error_px = (*back - pixel).norm();
      found.worst_px = std::max(found.worst_px, error_px);
      if (error_px > kMaxProjectionErrorPx) ++found.num_inaccurate;
    }
  });
  ProjectionError total;
  for (const ProjectionError& error : errors) {
    Add(error.valid_region, &total.valid_region);
    Add(error.others, &total.others);
  }
  return total;
}

}  // namespace raygrid
