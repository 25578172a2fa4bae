#include "camera/noncentral_generic.h"

#include <Eigen/LU>
#include <cassert>
#include <limits>
#include <utility>

#include "camera/stereographic.h"

namespace raygrid {

// Observation line of a pixel, and its derivatives with respect to the pixel.
struct NonCentralGeneric::LineDerivatives {
  Eigen::Vector2d chart;
  Eigen::Matrix2d J_chart;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 3, 2> J_origin = Eigen::Matrix<double, 3, 2>::Zero();
};

NonCentralGeneric::NonCentralGeneric(const ImageSize& image_size,
                                     BSplineSurface directions,
                                     std::vector<Eigen::Vector3d> points)
    : CameraModel(image_size, directions.area()),
      directions_(std::move(directions)),
      points_(std::move(points)),
      side_(ComputeUnfoldedSide(directions_)) {
  assert(static_cast<int>(points_.size()) == directions_.num_points());
}

NonCentralGeneric::NonCentralGeneric(const CentralGeneric& central)
    : NonCentralGeneric(
          central.image_size(), central.surface(),
          std::vector<Eigen::Vector3d>(central.surface().num_points(),
                                       Eigen::Vector3d::Zero())) {}

NonCentralGeneric::LineDerivatives NonCentralGeneric::Evaluate(
    const Eigen::Vector2d& pixel) const {
  LineDerivatives line;
  line.chart = directions_.Evaluate(pixel, &line.J_chart);
  const SplineSupport support = directions_.Support(pixel);
  for (int m = 0; m < 4; ++m) {
    const Eigen::Vector3d* row =
        &points_[(support.row + m) * directions_.columns() + support.column];
    for (int n = 0; n < 4; ++n) {
      line.origin += support.wy[m] * support.wx[n] * row[n];
      line.J_origin.col(0) += support.wy[m] * support.dwx[n] * row[n];
      line.J_origin.col(1) += support.dwy[m] * support.wx[n] * row[n];
    }
  }
  return line;
}

std::optional<Eigen::Vector3d> NonCentralGeneric::Unproject(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  return FromChart(directions_.Evaluate(pixel));
}

std::optional<ObservationLine> NonCentralGeneric::Line(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  const LineDerivatives line = Evaluate(pixel);
  return ObservationLine{line.origin, FromChart(line.chart)};
}

// Returns the pixel of the nearest control point: an initial value if Newton's
// method diverges from the centre.
Eigen::Vector2d NonCentralGeneric::NearestControlPoint(
    const Eigen::Vector3d& point) const {
  double min_value = std::numeric_limits<double>::infinity();
  int nearest = 0;
  for (int k = 0; k < directions_.num_points(); ++k) {
    const double distance =
        (ToChart(point - points_[k]) - directions_.points()[k]).squaredNorm();
    if (!(distance < min_value)) continue;
    min_value = distance;
    nearest = k;
  }
  return directions_.GetPixel(nearest);
}

std::optional<PixelSolution> NonCentralGeneric::Solve(
    const Eigen::Vector3d& point, const Eigen::Vector2d* start,
    double margin_px) const {
  if (!point.allFinite()) return std::nullopt;
  const auto error = [&](const Eigen::Vector2d& pixel,
                         Eigen::Matrix2d* derivative) -> Eigen::Vector2d {
    const LineDerivatives line = Evaluate(pixel);
    const Eigen::Vector3d sight = point - line.origin;
    *derivative = line.J_chart + ToChartDerivative(sight) * line.J_origin;
    return ToChart(sight) - line.chart;
  };
  const auto solution = FindPixel(area(), start ? *start : area().center(),
                                  margin_px, error, side_);
  if (solution || side_.folds()) return solution;
  return FindPixel(area(), NearestControlPoint(point), margin_px, error);
}

std::optional<Eigen::Vector2d> NonCentralGeneric::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* start,
    double margin_px) const {
  const auto solution = Solve(point, start, margin_px);
  if (!solution) return std::nullopt;
  return solution->pixel;
}

bool NonCentralGeneric::Linearize(const Eigen::Vector3d& point,
                                  const Eigen::Vector2d* start,
                                  double margin_px,
                                  LinearizedProjection* projection) const {
  const auto solution = Solve(point, start, margin_px);
  if (!solution) return false;
  const Eigen::Matrix2d inverse = solution->derivative.inverse();
  projection->pixel = solution->pixel;
  projection->J_point =
      inverse * ToChartDerivative(point - Evaluate(solution->pixel).origin);

  const SplineSupport support = directions_.Support(solution->pixel);
  projection->num_nodes = 16;
  projection->num_per_node = kPerNode;
  projection->J_node.leftCols<2>() = -inverse;
  projection->J_node.middleCols<3>(2) = -projection->J_point;
  for (int k = 0; k < 16; ++k) {
    const int index =
        (support.row + k / 4) * directions_.columns() + support.column + k % 4;
    projection->node_parameter[k] = kPerNode * index;
    projection->node_weight[k] = support.wy[k / 4] * support.wx[k % 4];
  }
  return true;
}

Eigen::VectorXd NonCentralGeneric::Parameters() const {
  Eigen::VectorXd parameters(kPerNode * directions_.num_points());
  for (int k = 0; k < directions_.num_points(); ++k)
    parameters.segment<kPerNode>(kPerNode * k) << directions_.points()[k],
        points_[k];
  return parameters;
}

void NonCentralGeneric::SetParameters(const Eigen::VectorXd& parameters) {
  for (int k = 0; k < directions_.num_points(); ++k) {
    directions_.points()[k] = parameters.segment<2>(kPerNode * k);
    points_[k] = parameters.segment<3>(kPerNode * k + 2);
  }
  side_ = ComputeUnfoldedSide(directions_);
}

std::unique_ptr<CameraModel> NonCentralGeneric::FittedTo(
    const CameraModel& other) const {
  return FitNonCentralGeneric(other, area(), directions_.columns(),
                              directions_.rows())
      .Clone();
}

NonCentralGeneric FitNonCentralGeneric(const CameraModel& model,
                                       const Area& area, int columns, int rows,
                                       int samples_per_cell) {
  const BSplineSurface grid(area, columns, rows);
  // Surfaces have two components, so the z coordinate of points is a separate
  // one.
  std::vector<SurfaceSample> directions, points_xy, points_z;
  for (const Eigen::Vector2d& pixel : grid.SamplePixels(samples_per_cell)) {
    const auto line = model.Line(pixel);
    if (!line) continue;
    directions.push_back({pixel, ToChart(line->direction)});
    points_xy.push_back({pixel, line->origin.head<2>()});
    points_z.push_back({pixel, {line->origin.z(), 0}});
  }
  const BSplineSurface xy = FitSurface(area, columns, rows, points_xy);
  const BSplineSurface z = FitSurface(area, columns, rows, points_z);
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < grid.num_points(); ++k)
    points.emplace_back(xy.points()[k].x(), xy.points()[k].y(),
                        z.points()[k].x());
  return NonCentralGeneric(model.image_size(),
                           FitSurface(area, columns, rows, directions),
                           std::move(points));
}

NonCentralGeneric NonCentralGeneric::WithOrigin(
    const Eigen::Vector3d& origin) const {
  NonCentralGeneric moved = *this;
  for (Eigen::Vector3d& point : moved.points_) point -= origin;
  return moved;
}

}  // namespace raygrid
