#include "exchange/unit_grid.h"

#include <algorithm>
#include <cmath>

#include "camera/noncentral_generic.h"
#include "camera/pixel_search.h"
#include "camera/stereographic.h"
#include "exchange/pixel_origin.h"

namespace raygrid {
namespace {

using Vectors = std::vector<Eigen::Vector3d>;

// Returns the area of the lattice, which extends to the outer edges of the
// pixels.
Area ComputeLatticeArea(const UnitGrid::Bounds& bounds) {
  constexpr PixelOrigin kOrigin = PixelOrigin::kImageCorner;
  const Eigen::Vector2d first =
      FromProgram(kOrigin, {}, {bounds.min_x, bounds.min_y});
  const Eigen::Vector2d last =
      FromProgram(kOrigin, {}, {bounds.max_x + 1, bounds.max_y + 1});
  return {first.x(), first.y(), last.x(), last.y()};
}

Area ComputeAreaInImage(const UnitGrid::Bounds& bounds, const ImageSize& size) {
  const Area lattice = ComputeLatticeArea(bounds), image = WholeImage(size);
  return {std::max(lattice.x0, image.x0), std::max(lattice.y0, image.y0),
          std::min(lattice.x1, image.x1), std::min(lattice.y1, image.y1)};
}

// Evaluates the vector-valued spline at a pixel, and its derivative.
Eigen::Vector3d Interpolate(const BSplineSurface& lattice,
                            const Vectors& vectors,
                            const Eigen::Vector2d& pixel,
                            Eigen::Matrix<double, 3, 2>* derivative) {
  const SplineSupport at = lattice.Support(pixel);
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  if (derivative) derivative->setZero();
  for (int m = 0; m < 4; ++m) {
    const Eigen::Vector3d* row =
        &vectors[(at.row + m) * lattice.columns() + at.column];
    for (int n = 0; n < 4; ++n) {
      value += at.wy[m] * at.wx[n] * row[n];
      if (!derivative) continue;
      derivative->col(0) += at.wy[m] * at.dwx[n] * row[n];
      derivative->col(1) += at.dwy[m] * at.wx[n] * row[n];
    }
  }
  return value;
}

// Whether the parametrization of directions can represent a vector: it cannot
// represent the backward direction.
bool HasChart(const Eigen::Vector3d& vector) {
  constexpr double kMinNorm = 1e-6;
  return vector.norm() > kMinNorm &&
         vector.norm() + vector.z() > kMinNorm * vector.norm();
}

// Fits control points to vectors sampled at pixels.
Vectors FitVectors(const BSplineSurface& lattice,
                   const std::vector<Eigen::Vector2d>& pixels,
                   const Vectors& values) {
  std::vector<SurfaceSample> xy, z;
  for (size_t k = 0; k < pixels.size(); ++k) {
    xy.push_back({pixels[k], values[k].head<2>()});
    z.push_back({pixels[k], {values[k].z(), 0}});
  }
  const int columns = lattice.columns(), rows = lattice.rows();
  const BSplineSurface fit_xy = FitSurface(lattice.area(), columns, rows, xy);
  const BSplineSurface fit_z = FitSurface(lattice.area(), columns, rows, z);
  Vectors fitted;
  for (int k = 0; k < lattice.num_points(); ++k)
    fitted.emplace_back(fit_xy.points()[k].x(), fit_xy.points()[k].y(),
                        fit_z.points()[k].x());
  return fitted;
}

// Fits unit control points. The interpolated vectors are normalized, so the fit
// is iterated on the remaining differences.
Vectors FitDirections(const BSplineSurface& lattice,
                      const std::vector<Eigen::Vector2d>& pixels,
                      const Vectors& rays) {
  constexpr int kRounds = 4;
  Vectors directions(lattice.num_points(), Eigen::Vector3d::Zero());
  Vectors left = rays;
  for (int round = 0; round < kRounds; ++round) {
    const Vectors step = FitVectors(lattice, pixels, left);
    for (size_t k = 0; k < step.size(); ++k)
      directions[k] = (directions[k] + step[k]).normalized();
    for (size_t k = 0; k < rays.size(); ++k)
      left[k] =
          rays[k] -
          Interpolate(lattice, directions, pixels[k], nullptr).normalized();
  }
  return directions;
}

// Returns the pixels whose centres are in the camera's area.
UnitGrid::Bounds ComputeBounds(const CameraModel& camera) {
  constexpr double kRounding = 1e-9;
  const auto first = [](double x) {
    return static_cast<int>(std::ceil(x - kRounding));
  };
  const auto last = [](double x) {
    return static_cast<int>(std::floor(x + kRounding));
  };
  const Area& area = camera.area();
  return {first(area.x0), first(area.y0), last(area.x1), last(area.y1)};
}

// Returns the numbers of control points: those of the camera's grid, otherwise
// for the default knot spacing.
std::pair<int, int> GetGridSize(const CameraModel& camera) {
  constexpr double kCellPx = 20, kMostCells = 100;
  if (const BSplineSurface* grid = camera.DirectionGrid())
    return {grid->columns(), grid->rows()};
  const double width = camera.area().width(), height = camera.area().height();
  const double knot_spacing_px =
      std::max(kCellPx, std::max(width, height) / kMostCells);
  return {NumControlPoints(width, knot_spacing_px),
          NumControlPoints(height, knot_spacing_px)};
}

}  // namespace

UnitGrid::UnitGrid(const ImageSize& image_size, const Bounds& bounds,
                   int columns, int rows, Vectors directions, Vectors points)
    : CameraModel(image_size, ComputeAreaInImage(bounds, image_size)),
      bounds_(bounds),
      lattice_(ComputeLatticeArea(bounds), columns, rows),
      directions_(std::move(directions)),
      points_(std::move(points)) {}

std::optional<Eigen::Vector3d> UnitGrid::Unproject(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  const Eigen::Vector3d direction =
      Interpolate(lattice_, directions_, pixel, nullptr);
  if (!HasChart(direction)) return std::nullopt;
  return direction.normalized();
}

std::optional<ObservationLine> UnitGrid::Line(
    const Eigen::Vector2d& pixel) const {
  const auto direction = Unproject(pixel);
  if (!direction) return std::nullopt;
  ObservationLine line;
  line.direction = *direction;
  if (!IsCentral())
    line.origin = Interpolate(lattice_, points_, pixel, nullptr);
  return line;
}

std::optional<Eigen::Vector2d> UnitGrid::Project(const Eigen::Vector3d& point,
                                                 const Eigen::Vector2d* start,
                                                 double margin_px) const {
  if (!point.allFinite()) return std::nullopt;
  const auto error = [&](const Eigen::Vector2d& pixel,
                         Eigen::Matrix2d* derivative) -> Eigen::Vector2d {
    Eigen::Matrix<double, 3, 2> by_pixel, origin_by_pixel;
    const Eigen::Vector3d direction =
        Interpolate(lattice_, directions_, pixel, &by_pixel);
    *derivative = ToChartDerivative(direction) * by_pixel;
    Eigen::Vector3d sight = point;
    if (!IsCentral()) {
      sight -= Interpolate(lattice_, points_, pixel, &origin_by_pixel);
      *derivative += ToChartDerivative(sight) * origin_by_pixel;
    }
    return ToChart(sight) - ToChart(direction);
  };
  const auto solution =
      FindPixel(area(), start ? *start : area().center(), margin_px, error);
  if (!solution) return std::nullopt;
  return solution->pixel;
}

Eigen::VectorXd UnitGrid::Parameters() const {
  Eigen::VectorXd parameters(3 * (directions_.size() + points_.size()));
  Eigen::Index at = 0;
  for (const Vectors* vectors : {&directions_, &points_})
    for (const Eigen::Vector3d& vector : *vectors) {
      parameters.segment<3>(at) = vector;
      at += 3;
    }
  return parameters;
}

void UnitGrid::SetParameters(const Eigen::VectorXd& parameters) {
  Eigen::Index at = 0;
  for (Vectors* vectors : {&directions_, &points_})
    for (Eigen::Vector3d& vector : *vectors) {
      vector = parameters.segment<3>(at);
      at += 3;
    }
}

UnitGrid FitUnitGrid(const CameraModel& camera, bool has_points) {
  const UnitGrid::Bounds bounds = ComputeBounds(camera);
  const auto [columns, rows] = GetGridSize(camera);
  const BSplineSurface lattice(ComputeLatticeArea(bounds), columns, rows);
  std::vector<Eigen::Vector2d> pixels;
  Vectors rays, origins;
  for (const Eigen::Vector2d& pixel : lattice.SamplePixels(4)) {
    // Samples on the lattice's edge are half a pixel outside the area.
    const Eigen::Vector2d inside = ClampToArea(pixel, camera.area(), 0);
    const auto line = camera.Line(inside);
    if (!line) continue;
    pixels.push_back(inside);
    rays.push_back(line->direction);
    origins.push_back(line->origin);
  }
  return {camera.image_size(),
          bounds,
          columns,
          rows,
          FitDirections(lattice, pixels, rays),
          has_points ? FitVectors(lattice, pixels, origins) : Vectors{}};
}

}  // namespace raygrid
