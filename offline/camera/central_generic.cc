#include "camera/central_generic.h"

#include <Eigen/LU>
#include <algorithm>

#include "camera/pixel_search.h"
#include "camera/stereographic.h"

namespace raygrid {
namespace {

// Returns the control point nearest to the target: an initial value if Newton's
// method diverges from the centre.
Eigen::Vector2d FindNearestControlPoint(const BSplineSurface& surface,
                                        const Eigen::Vector2d& target) {
  const auto& points = surface.points();
  const auto nearest = std::min_element(
      points.begin(), points.end(), [&target](const auto& a, const auto& b) {
        return (a - target).squaredNorm() < (b - target).squaredNorm();
      });
  return surface.GetPixel(static_cast<int>(nearest - points.begin()));
}

std::optional<PixelSolution> Solve(const BSplineSurface& surface,
                                   const UnfoldedSide& side,
                                   const Eigen::Vector2d& target,
                                   const Eigen::Vector2d* start,
                                   double margin_px) {
  if (!target.allFinite()) return std::nullopt;
  const auto error = [&](const Eigen::Vector2d& pixel,
                         Eigen::Matrix2d* derivative) -> Eigen::Vector2d {
    return target - surface.Evaluate(pixel, derivative);
  };
  const Area& area = surface.area();
  const auto solution =
      FindPixel(area, start ? *start : area.center(), margin_px, error, side);
  if (solution || side.folds()) return solution;
  return FindPixel(area, FindNearestControlPoint(surface, target), margin_px,
                   error);
}

}  // namespace

CentralGeneric::CentralGeneric(const ImageSize& image_size,
                               BSplineSurface surface)
    : CameraModel(image_size, surface.area()),
      surface_(std::move(surface)),
      side_(ComputeUnfoldedSide(surface_)) {}

std::optional<Eigen::Vector3d> CentralGeneric::Unproject(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  return FromChart(surface_.Evaluate(pixel));
}

std::optional<Eigen::Vector2d> CentralGeneric::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* start,
    double margin_px) const {
  const auto solution =
      Solve(surface_, side_, ToChart(point), start, margin_px);
  if (!solution) return std::nullopt;
  return solution->pixel;
}

bool CentralGeneric::Linearize(const Eigen::Vector3d& point,
                               const Eigen::Vector2d* start, double margin_px,
                               LinearizedProjection* projection) const {
  const auto solution =
      Solve(surface_, side_, ToChart(point), start, margin_px);
  if (!solution) return false;
  const Eigen::Matrix2d inverse = solution->derivative.inverse();
  projection->pixel = solution->pixel;
  projection->J_point = inverse * ToChartDerivative(point);

  const SplineSupport support = surface_.Support(solution->pixel);
  projection->num_nodes = 16;
  projection->num_per_node = 2;
  projection->J_node.leftCols<2>() = -inverse;
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
  side_ = ComputeUnfoldedSide(surface_);
}

std::unique_ptr<CameraModel> CentralGeneric::FittedTo(
    const CameraModel& other) const {
  return FitCentralGeneric(other, area(), surface_.columns(), surface_.rows())
      .Clone();
}

CentralGeneric MakeCentral(const CameraModel& generic) {
  CentralGeneric central(generic.image_size(), *generic.DirectionGrid());
  central.SetImageCircle(generic.image_circle());
  return central;
}

CentralGeneric FitCentralGeneric(const CameraModel& model, const Area& area,
                                 int columns, int rows, int samples_per_cell) {
  const BSplineSurface grid(area, columns, rows);
  std::vector<SurfaceSample> samples;
  for (const Eigen::Vector2d& pixel : grid.SamplePixels(samples_per_cell)) {
    const auto direction = model.Unproject(pixel);
    if (direction) samples.push_back({pixel, ToChart(*direction)});
  }
  return CentralGeneric(model.image_size(),
                        FitSurface(area, columns, rows, samples));
}

}  // namespace raygrid
