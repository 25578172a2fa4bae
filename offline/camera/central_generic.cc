#include "camera/central_generic.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "camera/stereographic.h"

namespace raygrid {
namespace {

constexpr int kMaxIterations = 50;
constexpr double kConvergedPx = 1e-9;
constexpr double kAcceptedPx = 1e-6;

// A solution of s(x) = target, and the surface's derivative there.
struct SurfaceSolution {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d derivative;
};

Eigen::Vector2d Clamp(const Eigen::Vector2d& pixel, const Area& area,
                      double margin_px) {
  return {std::clamp(pixel.x(), area.x0 - margin_px, area.x1 + margin_px),
          std::clamp(pixel.y(), area.y0 - margin_px, area.y1 + margin_px)};
}

// Newton's method with step halving, within the area (paper, "Projection").
std::optional<SurfaceSolution> SolveFrom(const BSplineSurface& surface,
                                         const Eigen::Vector2d& target,
                                         const Eigen::Vector2d& start,
                                         double margin_px) {
  SurfaceSolution at;
  at.pixel = Clamp(start, surface.area(), margin_px);
  Eigen::Vector2d error = target - surface.Evaluate(at.pixel, &at.derivative);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const double determinant = at.derivative.determinant();
    if (!(std::abs(determinant) > 1e-30)) return std::nullopt;
    const Eigen::Vector2d newton = at.derivative.inverse() * error;
    if (newton.norm() < kConvergedPx) return at;

    bool improved = false;
    for (double length = 1; length > 1e-3 && !improved; length /= 2) {
      SurfaceSolution next;
      next.pixel = Clamp(at.pixel + length * newton, surface.area(), margin_px);
      const Eigen::Vector2d next_error =
          target - surface.Evaluate(next.pixel, &next.derivative);
      if (next_error.squaredNorm() >= error.squaredNorm()) continue;
      improved = true;
      at = next;
      error = next_error;
    }
    // No decrease: converged as far as rounding allows, or stuck at the edge.
    if (!improved)
      return newton.norm() < kAcceptedPx ? std::optional(at) : std::nullopt;
  }
  return std::nullopt;
}

// The control point nearest to the target, as a start where Newton's method
// from the centre went astray.
Eigen::Vector2d NearestControlPoint(const BSplineSurface& surface,
                                    const Eigen::Vector2d& target) {
  const auto& points = surface.points();
  const auto nearest = std::min_element(
      points.begin(), points.end(), [&target](const auto& a, const auto& b) {
        return (a - target).squaredNorm() < (b - target).squaredNorm();
      });
  const int index = static_cast<int>(nearest - points.begin());
  return {surface.area().x0 +
              (index % surface.columns() - 1) * surface.cell_width(),
          surface.area().y0 +
              (index / surface.columns() - 1) * surface.cell_height()};
}

std::optional<SurfaceSolution> Solve(const BSplineSurface& surface,
                                     const Eigen::Vector2d& target,
                                     const Eigen::Vector2d* start,
                                     double margin_px) {
  if (!target.allFinite()) return std::nullopt;
  std::optional<SurfaceSolution> solution = SolveFrom(
      surface, target, start ? *start : surface.area().center(), margin_px);
  if (!solution)
    solution = SolveFrom(surface, target, NearestControlPoint(surface, target),
                         margin_px);
  return solution;
}

}  // namespace

CentralGeneric::CentralGeneric(const ImageSize& image_size,
                               BSplineSurface surface)
    : CameraModel(image_size, surface.area()), surface_(std::move(surface)) {}

std::optional<Eigen::Vector3d> CentralGeneric::Unproject(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  return FromChart(surface_.Evaluate(pixel));
}

std::optional<Eigen::Vector2d> CentralGeneric::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* start,
    double margin_px) const {
  const auto solution = Solve(surface_, ToChart(point), start, margin_px);
  if (!solution) return std::nullopt;
  return solution->pixel;
}

bool CentralGeneric::Linearize(const Eigen::Vector3d& point,
                               const Eigen::Vector2d* start, double margin_px,
                               LinearizedProjection* projection) const {
  const auto solution = Solve(surface_, ToChart(point), start, margin_px);
  if (!solution) return false;
  const Eigen::Matrix2d inverse = solution->derivative.inverse();
  projection->pixel = solution->pixel;
  projection->by_point = inverse * ToChartDerivative(point);

  const SplineSupport support = surface_.Support(solution->pixel);
  projection->num_nodes = 16;
  projection->num_per_node = 2;
  projection->by_node.leftCols<2>() = -inverse;
  for (int k = 0; k < 16; ++k) {
    const int index =
        (support.row + k / 4) * surface_.columns() + support.column + k % 4;
    projection->node_parameter[k] = 2 * index;
    projection->node_weight[k] = support.wy[k / 4] * support.wx[k % 4];
  }
  return true;
}

Eigen::VectorXd CentralGeneric::Parameters() const {
  return Eigen::Map<const Eigen::VectorXd>(surface_.points().front().data(),
                                           2 * surface_.num_points());
}

void CentralGeneric::SetParameters(const Eigen::VectorXd& parameters) {
  Eigen::Map<Eigen::VectorXd>(surface_.points().front().data(),
                              2 * surface_.num_points()) = parameters;
}

CentralGeneric FitCentralGeneric(const CameraModel& model, const Area& area,
                                 int columns, int rows, int samples_per_cell) {
  std::vector<SurfaceSample> samples;
  const int num_x = (columns - 3) * samples_per_cell;
  const int num_y = (rows - 3) * samples_per_cell;
  for (int j = 0; j <= num_y; ++j) {
    for (int i = 0; i <= num_x; ++i) {
      const Eigen::Vector2d pixel(area.x0 + area.width() * i / num_x,
                                  area.y0 + area.height() * j / num_y);
      const auto direction = model.Unproject(pixel);
      if (direction) samples.push_back({pixel, ToChart(*direction)});
    }
  }
  return CentralGeneric(model.image_size(),
                        FitSurface(area, columns, rows, samples));
}

}  // namespace raygrid
