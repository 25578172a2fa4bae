#include "camera/splined_stereographic.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "camera/pixel_search.h"
#include "camera/stereographic.h"

namespace raygrid {
namespace {

using SplineGrid = SplinedStereographic::Grid;

Eigen::Vector2d ProjectToPlane(const Eigen::Vector3d& direction) {
  return 2 * ToChart(direction);
}

// Returns u + d(u), and its derivative with respect to u.
Eigen::Vector2d ApplyCorrection(const BSplineSurface& surface,
                                const Eigen::Vector2d& u,
                                Eigen::Matrix2d* derivative) {
  const Eigen::Vector2d d = surface.Evaluate(u, derivative);
  *derivative += Eigen::Matrix2d::Identity();
  return u + d;
}

// Returns the control point whose corrected position is nearest to a target: an
// initial value if Newton's method diverges.
Eigen::Vector2d FindNearestGridPosition(const BSplineSurface& surface,
                                        const Eigen::Vector2d& target) {
  Eigen::Vector2d nearest = surface.area().center();
  double least = INFINITY;
  for (int k = 0; k < surface.num_points(); ++k) {
    const Eigen::Vector2d place = surface.GetPixel(k);
    const double distance =
        (place + surface.points()[k] - target).squaredNorm();
    if (!(distance < least)) continue;
    least = distance;
    nearest = place;
  }
  return nearest;
}

// ---- The fit ---------------------------------------------------------------

struct PlaneSample {
  Eigen::Vector2d u, pixel;
  double weight;
};

// Samples a lattice of pixels, about `across` along the longer side. Omits
// directions that blobs cannot represent and that cover most of the
// stereographic plane.
std::vector<PlaneSample> SamplePlane(const CameraModel& camera,
                                     const ValidityMask* valid_region,
                                     double across) {
  constexpr double kInvalidWeight = 1e-6, kMaxPlaneRadius = 8;
  const Area& area = camera.area();
  const double step_px = std::max(area.width(), area.height()) / across;
  const int columns = static_cast<int>(area.width() / step_px + 1e-9);
  const int rows = static_cast<int>(area.height() / step_px + 1e-9);
  std::vector<PlaneSample> samples;
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      const Eigen::Vector2d pixel(
          area.x0 + area.width() * i / std::max(columns, 1),
          area.y0 + area.height() * j / std::max(rows, 1));
      if (!camera.IsInImageCircle(pixel)) continue;
      const auto ray = camera.Unproject(pixel);
      if (!ray) continue;
      const Eigen::Vector2d u = ProjectToPlane(*ray);
      if (!(u.norm() < kMaxPlaneRadius)) continue;
      const bool is_valid = !valid_region || valid_region->IsValidAt(pixel);
      samples.push_back({u, pixel, is_valid ? 1 : kInvalidWeight});
    }
  }
  return samples;
}

// Fits the focal length and principal point along an axis by linear regression.
std::pair<double, double> FitLine(const std::vector<PlaneSample>& samples,
                                  int axis) {
  double sum = 0, sum_u = 0, sum_x = 0, sum_uu = 0, sum_ux = 0;
  for (const PlaneSample& sample : samples) {
    const double w = sample.weight, u = sample.u[axis], x = sample.pixel[axis];
    sum += w;
    sum_u += w * u;
    sum_x += w * x;
    sum_uu += w * u * u;
    sum_ux += w * u * x;
  }
  const double focal_px =
      (sum * sum_ux - sum_u * sum_x) / (sum * sum_uu - sum_u * sum_u);
  return {focal_px, (sum_x - focal_px * sum_u) / sum};
}

// Returns the maximum stereographic coordinates of the samples.
Eigen::Array2d ComputeMaxExtent(const std::vector<PlaneSample>& samples) {
  Eigen::Array2d widest = Eigen::Array2d::Constant(1e-3);
  for (const PlaneSample& sample : samples)
    widest = widest.max(sample.u.array().abs());
  return widest;
}

// Returns the field of view, in whole degrees, of a grid that extends to an
// edge or slightly further.
int ComputeFovDeg(double edge) {
  constexpr int kMaxDeg = 359;
  const double fov_deg = 4 * std::atan(edge / 2) * 180 / M_PI;
  return std::min(kMaxDeg, static_cast<int>(std::ceil(fov_deg + 0.1)));
}

// Makes a grid that covers all samples, with at least `along` control points
// along the longer side.
SplineGrid MakeCoveringGrid(const Eigen::Array2d& widest, int along) {
  const double min_cell = 2 * widest.maxCoeff() / (along - 3);
  SplineGrid grid;
  grid.columns = NumControlPoints(2 * widest.x(), min_cell);
  grid.fov_x_deg =
      ComputeFovDeg(std::max(widest.x(), min_cell * (grid.columns - 3) / 2));
  const double cell = ComputeDomain(grid).width() / (grid.columns - 3);
  grid.rows = NumControlPoints(2 * widest.y(), cell);
  return grid;
}

// Returns the prescribed grid; if its field of view is 0, it is set such that
// the grid covers all samples.
SplineGrid SelectGrid(const Eigen::Array2d& widest, SplineGrid grid) {
  if (grid.fov_x_deg != 0) return grid;
  const double row_edge = widest.y() * (grid.columns - 3) / (grid.rows - 3);
  grid.fov_x_deg = ComputeFovDeg(std::max(widest.x(), row_edge));
  return grid;
}

Eigen::VectorXd PackParameters(const BSplineSurface& surface,
                               const Eigen::Vector4d& others) {
  Eigen::VectorXd parameters(2 * surface.num_points() + 4);
  parameters << Eigen::Map<const Eigen::VectorXd>(
      surface.points().front().data(), 2 * surface.num_points()),
      others;
  return parameters;
}

// Returns the error criterion for the selection of a grid: RMS error of valid
// samples, or the median of all samples if it is larger, because errors of
// invalid samples may be arbitrary.
double ChoiceErrorPx(const SplinedStereographic& model,
                     const std::vector<PlaneSample>& samples) {
  const Eigen::Vector4d others = model.Parameters().tail<4>();
  std::vector<double> errors_px;
  double sum = 0, count = 0;
  for (const PlaneSample& sample : samples) {
    const Eigen::Vector2d u = sample.u + model.surface().Evaluate(sample.u);
    errors_px.push_back(
        (others.head<2>().cwiseProduct(u) + others.tail<2>() - sample.pixel)
            .norm());
    if (sample.weight < 1) continue;
    sum += errors_px.back() * errors_px.back();
    ++count;
  }
  const auto median =
      errors_px.begin() + static_cast<std::ptrdiff_t>(errors_px.size() / 2);
  std::nth_element(errors_px.begin(), median, errors_px.end());
  return std::max(*median, std::sqrt(sum / std::max(count, 1.0)));
}

// Fits the spline of a grid. Samples outside a prescribed grid are ignored.
std::unique_ptr<SplinedStereographic> FitGrid(
    const CameraModel& camera, const std::vector<PlaneSample>& samples,
    const Eigen::Vector4d& others, const SplineGrid& grid) {
  const Area domain = ComputeDomain(grid);
  std::vector<SurfaceSample> corrections;
  for (const PlaneSample& sample : samples) {
    if (!domain.Contains(sample.u, 1e-9)) continue;
    const Eigen::Vector2d target =
        (sample.pixel - others.tail<2>()).cwiseQuotient(others.head<2>());
    corrections.push_back({sample.u, target - sample.u, sample.weight});
  }
  return std::make_unique<SplinedStereographic>(
      camera.image_size(), camera.area(), grid,
      PackParameters(FitSurface(domain, grid.columns, grid.rows, corrections),
                     others));
}

}  // namespace

Area ComputeDomain(const SplinedStereographic::Grid& grid) {
  const double x = 2 * std::tan(grid.fov_x_deg * M_PI / 180 / 4);
  const double y = x * (grid.rows - 3) / (grid.columns - 3);
  return {-x, -y, x, y};
}

SplinedStereographic::SplinedStereographic(const ImageSize& image_size,
                                           const Area& area, const Grid& grid,
                                           const Eigen::VectorXd& parameters)
    : ParametricModel(image_size, area),
      grid_(grid),
      surface_(ComputeDomain(grid), grid.columns, grid.rows) {
  SetParameters(parameters);
}

const std::vector<std::string>& SplinedStereographic::ParameterNames() const {
  static const std::vector<std::string> names = {"fx", "fy", "cx", "cy"};
  return names;
}

Eigen::VectorXd SplinedStereographic::Parameters() const {
  Eigen::Vector4d others;
  others << focal_px_, center_px_;
  return PackParameters(surface_, others);
}

void SplinedStereographic::SetParameters(const Eigen::VectorXd& parameters) {
  const Eigen::Index count = 2 * surface_.num_points();
  Eigen::Map<Eigen::VectorXd>(surface_.points().front().data(), count) =
      parameters.head(count);
  focal_px_ = parameters.segment<2>(count);
  center_px_ = parameters.segment<2>(count + 2);
}

std::optional<Eigen::Vector3d> SplinedStereographic::Unproject(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  const Eigen::Vector2d target = (pixel.array() - center_px_) / focal_px_;
  const auto error = [&](const Eigen::Vector2d& u,
                         Eigen::Matrix2d* derivative) -> Eigen::Vector2d {
    return target - ApplyCorrection(surface_, u, derivative);
  };
  const Area& domain = surface_.area();
  auto solution = FindPixel(domain, target, 0, error);
  if (!solution)
    solution =
        FindPixel(domain, FindNearestGridPosition(surface_, target), 0, error);
  if (!solution || !(solution->derivative.determinant() > 0))
    return std::nullopt;
  // Adds a final Newton step: the search ends at steps of 1e-9, in units of the
  // focal length.
  Eigen::Matrix2d ignored;
  const Eigen::Vector2d u =
      solution->pixel +
      solution->derivative.inverse() * error(solution->pixel, &ignored);
  return FromChart(u / 2);
}

std::optional<Eigen::Vector2d> SplinedStereographic::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* /*start*/,
    double margin_px) const {
  constexpr double kRounding = 1e-9;
  const Eigen::Vector2d u = ProjectToPlane(point);
  if (!u.allFinite() || !surface_.area().Contains(u, kRounding))
    return std::nullopt;
  Eigen::Matrix2d derivative;
  const Eigen::Vector2d corrected = ApplyCorrection(surface_, u, &derivative);
  const Eigen::Vector2d pixel = focal_px_ * corrected.array() + center_px_;
  if (!(derivative.determinant() > 0) || !area().Contains(pixel, margin_px))
    return std::nullopt;
  return pixel;
}

bool SplinedStereographic::Linearize(const Eigen::Vector3d& point,
                                     const Eigen::Vector2d* start,
                                     double margin_px,
                                     LinearizedProjection* projection) const {
  const auto pixel = Project(point, start, margin_px);
  if (!pixel) return false;
  const Eigen::Vector2d u = ProjectToPlane(point);
  Eigen::Matrix2d derivative;
  const Eigen::Vector2d corrected = ApplyCorrection(surface_, u, &derivative);
  const auto focal = focal_px_.matrix().asDiagonal();
  projection->pixel = *pixel;
  projection->J_point = focal * derivative * 2 * ToChartDerivative(point);

  const SplineSupport support = surface_.Support(u);
  projection->num_nodes = 16;
  projection->num_per_node = 2;
  projection->J_node.leftCols<2>() = focal;
  for (int k = 0; k < 16; ++k) {
    const int index =
        (support.row + k / 4) * surface_.columns() + support.column + k % 4;
    projection->node_parameter[k] = 2 * index;
    projection->node_weight[k] = support.wy[k / 4] * support.wx[k % 4];
  }
  projection->num_global = 4;
  projection->first_global = 2 * surface_.num_points();
  projection->J_global.leftCols<4>() << corrected.x(), 0, 1, 0, 0,
      corrected.y(), 0, 1;
  return true;
}

std::unique_ptr<SplinedStereographic> FitSplinedStereographic(
    const CameraModel& camera, const ValidityMask* valid_region,
    const std::optional<SplinedStereographic::Grid>& given_grid) {
  constexpr double kMinImprovementFraction = 0.02, kNegligibleRmsPx = 0.005;
  constexpr double kMinSamplesAcross = 160, kSamplesPerCell = 4;
  std::vector<PlaneSample> samples =
      SamplePlane(camera, valid_region, kMinSamplesAcross);
  if (samples.empty()) return nullptr;
  const auto [fx, cx] = FitLine(samples, 0);
  const auto [fy, cy] = FitLine(samples, 1);
  if (!(fx > 0 && fy > 0)) return nullptr;
  const Eigen::Vector4d others(fx, fy, cx, cy);
  const Eigen::Array2d widest = ComputeMaxExtent(samples);
  std::vector<SplineGrid> grids;
  if (given_grid) {
    grids = {SelectGrid(widest, *given_grid)};
  } else {
    for (const int along : {10, 15, 22, 33, 50, 75, 112})
      grids.push_back(MakeCoveringGrid(widest, along));
  }
  std::vector<std::unique_ptr<SplinedStereographic>> fits;
  std::vector<double> errors_px;
  for (const SplineGrid& grid : grids) {
    const double across = kSamplesPerCell * std::max(grid.columns, grid.rows);
    if (across > kMinSamplesAcross)
      samples = SamplePlane(camera, valid_region, across);
    fits.push_back(FitGrid(camera, samples, others, grid));
    errors_px.push_back(ChoiceErrorPx(*fits.back(), samples));
    if (errors_px.back() < kNegligibleRmsPx) break;
  }
  const double least_px = *std::min_element(errors_px.begin(), errors_px.end());
  const auto chosen =
      std::find_if(errors_px.begin(), errors_px.end(), [&](double error_px) {
        return error_px <= least_px / (1 - kMinImprovementFraction);
      });
  return std::move(fits[chosen - errors_px.begin()]);
}

}  // namespace raygrid
