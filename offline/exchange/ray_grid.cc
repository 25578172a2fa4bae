#include "exchange/ray_grid.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "camera/noncentral_generic.h"
#include "camera/stereographic.h"
#include "dataset/error.h"
#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

using models::kCentralGeneric;
using models::kNonCentralGeneric;

// A pixel and its observation line.
struct RaySample {
  Eigen::Vector2d pixel;
  Eigen::Vector3d direction, origin;
  bool is_white = false;  // on a checkerboard of samples, for cross-validation
};

// Returns all rays, or every n-th row and column, including the last ones, of
// large tables.
std::vector<RaySample> GetSamples(const RayTable& rays) {
  constexpr size_t kMaxAlong = 320;
  const size_t step =
      std::max<size_t>(1, std::max(rays.x.size(), rays.y.size()) / kMaxAlong);
  const auto is_selected = [&](size_t k, size_t count) {
    return k % step == 0 || k + 1 == count;
  };
  std::vector<RaySample> samples;
  for (size_t row = 0; row < rays.y.size(); ++row)
    for (size_t column = 0; column < rays.x.size(); ++column) {
      const size_t k = row * rays.x.size() + column;
      if (!is_selected(row, rays.y.size()) ||
          !is_selected(column, rays.x.size()) ||
          !rays.directions[k].allFinite())
        continue;
      samples.push_back(
          {rays.pixels.empty() ? Eigen::Vector2d(rays.x[column], rays.y[row])
                               : rays.pixels[k],
           rays.directions[k],
           rays.origins.empty() ? Eigen::Vector3d(0, 0, 0) : rays.origins[k],
           (row / step + column / step) % 2 == 0});
    }
  return samples;
}

void RequireCameraAxes(const RayTable& rays,
                       const std::vector<RaySample>& samples) {
  constexpr size_t kFewest = 16;
  constexpr double kBackwards = -0.998;
  Eigen::Vector3d mean(0, 0, 0);
  double lowest = 1;
  for (const RaySample& sample : samples) {
    mean += sample.direction;
    lowest = std::min(lowest, sample.direction.z());
  }
  if (samples.size() < kFewest)
    throw InputError(fmt::format("{}: too few directions ({}) for a camera",
                                 rays.path, samples.size()));
  if (!(mean.z() > 0) || lowest < kBackwards)
    throw InputError(
        fmt::format("{}: directions point backwards; axes must be x right, y "
                    "down, z forward",
                    rays.path));
}

// Whether all observation lines of a table pass through the origin.
bool IsCentralTable(const std::vector<RaySample>& samples) {
  constexpr double kMaxOriginDistanceM = 1e-9;
  return std::all_of(samples.begin(), samples.end(), [](const RaySample& ray) {
    return ray.origin.cross(ray.direction).norm() <= kMaxOriginDistanceM;
  });
}

std::string SelectTableModel(const std::string& model,
                             const std::vector<RaySample>& samples) {
  if (model.empty())
    return IsCentralTable(samples) ? kCentralGeneric : kNonCentralGeneric;
  if (model == kCentralGeneric || model == kNonCentralGeneric) return model;
  throw Error(ExitCode::kUsage,
              fmt::format("--model {}: rays can be imported as {} or {} only; "
                          "convert with 'raygrid fit'",
                          model, kCentralGeneric, kNonCentralGeneric));
}

BSplineSurface MakeSurface(const Area& area, int columns, int rows,
                           const std::vector<RaySample>& samples,
                           Eigen::Vector2d (*value)(const RaySample&)) {
  std::vector<SurfaceSample> points;
  points.reserve(samples.size());
  for (const RaySample& sample : samples)
    points.push_back({sample.pixel, value(sample)});
  return FitSurface(area, columns, rows, points);
}

std::unique_ptr<CameraModel> FitGridTo(const RayTable& rays,
                                       const std::vector<RaySample>& samples,
                                       const Area& area, int columns, int rows,
                                       bool is_central) {
  const auto surface = [&](Eigen::Vector2d (*value)(const RaySample&)) {
    return MakeSurface(area, columns, rows, samples, value);
  };
  const BSplineSurface directions =
      surface([](const RaySample& ray) { return ToChart(ray.direction); });
  if (ComputeDominantHandedness(directions) < 0)
    throw InputError(
        fmt::format("{}: the image is mirrored; axes must be x right, y down, "
                    "z forward, and t of an STMap increases upwards",
                    rays.path));
  if (is_central)
    return std::make_unique<CentralGeneric>(rays.image_size, directions);
  const BSplineSurface xy = surface([](const RaySample& ray) {
    return Eigen::Vector2d(ray.origin.head<2>());
  });
  const BSplineSurface z = surface(
      [](const RaySample& ray) { return Eigen::Vector2d(ray.origin.z(), 0); });
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < xy.num_points(); ++k)
    points.emplace_back(xy.points()[k].x(), xy.points()[k].y(),
                        z.points()[k].x());
  return std::make_unique<NonCentralGeneric>(rays.image_size, directions,
                                             std::move(points));
}

// Computes the reprojection errors of the camera at the samples; large for rays
// without a projection.
void MeasureGrid(const std::vector<RaySample>& samples, int num_threads,
                 RayGrid* grid) {
  constexpr double kUnseenPx = 100, kMarginPx = 2, kDistanceM = 1;
  constexpr int kBatch = 1024;
  std::vector<double> errors(samples.size());
  const int num_batches =
      static_cast<int>((samples.size() + kBatch - 1) / kBatch);
  ParallelFor(num_batches, NumThreads(num_threads), [&](int batch) {
    const size_t begin = static_cast<size_t>(batch) * kBatch;
    for (size_t k = begin; k < std::min(samples.size(), begin + kBatch); ++k) {
      const RaySample& ray = samples[k];
      const auto seen = grid->camera->Project(
          ray.origin + kDistanceM * ray.direction, &ray.pixel, kMarginPx);
      errors[k] = seen ? (*seen - ray.pixel).norm() : kUnseenPx;
    }
  });
  double sum = 0;
  grid->max_px = 0;
  for (const double error : errors) {
    sum += error * error;
    grid->max_px = std::max(grid->max_px, error);
  }
  grid->rms_px = std::sqrt(sum / static_cast<double>(errors.size()));
  grid->num_pixels = errors.size();
}

Area ComputeArea(const std::vector<RaySample>& samples) {
  const Eigen::Vector2d& first = samples.front().pixel;
  Area area = {first.x(), first.y(), first.x(), first.y()};
  for (const RaySample& sample : samples) area.Extend(sample.pixel);
  return area;
}

// Returns the number of control points along the longer axis for four samples
// per cell.
int ComputeMaxPointsAlong(const Area& area,
                          const std::vector<RaySample>& samples) {
  const double sample_px = std::sqrt(area.width() * area.height() /
                                     static_cast<double>(samples.size()));
  return 3 + static_cast<int>(std::max(area.width(), area.height()) /
                              (2 * sample_px));
}

// Cross-validates: fits a grid of the same size to the white samples and
// returns its RMS error at the black ones.
double ComputeCheckerboardRmsPx(const RayTable& rays,
                                const std::vector<RaySample>& samples,
                                const Area& area, const RayGrid& grid,
                                int num_threads) {
  std::vector<RaySample> white, black;
  for (const RaySample& sample : samples)
    (sample.is_white ? white : black).push_back(sample);
  if (white.empty() || black.empty()) return 0;
  RayGrid half;
  half.camera = FitGridTo(rays, white, area, grid.columns, grid.rows,
                          grid.camera->IsCentral());
  MeasureGrid(black, num_threads, &half);
  return half.rms_px;
}

// Returns the number of control points along an axis of a grid with `along`
// points along the longer axis.
int CountPointsOnAxis(double extent, double longest, int along) {
  return 3 + std::max(1, static_cast<int>(
                             std::lround((along - 3) * extent / longest)));
}

// Returns the fraction of image cells without a sample, for tables whose rows
// and columns are not those of the image.
double ComputeEmptyCellFraction(const ImageSize& size,
                                const std::vector<RaySample>& samples) {
  constexpr int kMaxAlong = 64, kSamplesAlong = 4;
  const int along =
      std::clamp(static_cast<int>(std::sqrt(samples.size())) / kSamplesAlong, 1,
                 kMaxAlong);
  std::vector<bool> is_seen(static_cast<size_t>(along) * along);
  const auto cell_of = [&](double place, int pixels) {
    return std::clamp(static_cast<int>((place + 0.5) / pixels * along), 0,
                      along - 1);
  };
  for (const RaySample& sample : samples)
    is_seen[cell_of(sample.pixel.y(), size.height) * along +
            cell_of(sample.pixel.x(), size.width)] = true;
  return static_cast<double>(
             std::count(is_seen.begin(), is_seen.end(), false)) /
         static_cast<double>(is_seen.size());
}

double ComputeUndefinedFraction(const RayTable& rays,
                                const std::vector<RaySample>& samples) {
  if (!rays.pixels.empty())
    return ComputeEmptyCellFraction(rays.image_size, samples);
  const auto count = std::count_if(
      rays.directions.begin(), rays.directions.end(),
      [](const Eigen::Vector3d& ray) { return !ray.allFinite(); });
  return static_cast<double>(count) /
         static_cast<double>(rays.directions.size());
}

}  // namespace

RayGrid FitRayGrid(const RayTable& rays, const std::string& model,
                   int num_threads) {
  constexpr double kMaxRmsPx = 0.002, kMaxErrorRatio = 1.25;
  constexpr int kFewest = 8, kMost = 96;
  const std::vector<RaySample> samples = GetSamples(rays);
  RequireCameraAxes(rays, samples);
  const bool is_central = SelectTableModel(model, samples) == kCentralGeneric;
  const Area area = ComputeArea(samples);
  const double longest = std::max(area.width(), area.height());
  const int most =
      std::clamp(ComputeMaxPointsAlong(area, samples), kFewest, kMost);
  std::vector<RayGrid> grids;
  for (int along = kFewest; along <= most; along += along / 2) {
    RayGrid grid;
    grid.columns = CountPointsOnAxis(area.width(), longest, along);
    grid.rows = CountPointsOnAxis(area.height(), longest, along);
    grid.camera =
        FitGridTo(rays, samples, area, grid.columns, grid.rows, is_central);
    MeasureGrid(samples, num_threads, &grid);
    grids.push_back(std::move(grid));
    if (grids.back().rms_px < kMaxRmsPx) break;
  }
  double least_px = grids.front().rms_px;
  for (const RayGrid& grid : grids) least_px = std::min(least_px, grid.rms_px);
  const double accepted_px = std::max(kMaxRmsPx, kMaxErrorRatio * least_px);
  RayGrid best = std::move(*std::find_if(
      grids.begin(), grids.end(),
      [&](const RayGrid& grid) { return grid.rms_px <= accepted_px; }));
  best.fraction_without_rays = ComputeUndefinedFraction(rays, samples);
  best.left_out_rms_px =
      ComputeCheckerboardRmsPx(rays, samples, area, best, num_threads);
  return best;
}

}  // namespace raygrid
