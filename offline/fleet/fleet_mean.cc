#include "fleet/fleet_mean.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <memory>

#include "camera/bspline_surface.h"
#include "camera/central_generic.h"
#include "camera/lens_displacements.h"
#include "camera/stereographic.h"
#include "fleet/area_polynomials.h"
#include "fleet/population_estimation.h"
#include "fleet/robust_series.h"

namespace raygrid {
namespace {

// Returns the cameras of inlier units; empty if one of them is not central.
std::vector<CameraFile> SelectInlierCameras(
    const FleetAnalysis& fleet, const std::vector<std::string>& folders) {
  std::vector<size_t> inliers;
  for (const size_t row : fleet.compared)
    if (fleet.rows[row].outliers.empty()) inliers.push_back(row);
  constexpr size_t kMost = 200;
  const size_t count = std::min(inliers.size(), kMost);
  std::vector<CameraFile> cameras;
  for (size_t k = 0; k < count; ++k) {
    const std::string& folder = folders[inliers[k * inliers.size() / count]];
    cameras.push_back(ReadCameraFile(folder + "/camera.yaml"));
    if (!cameras.back().camera->IsCentral()) return {};
  }
  return cameras;
}

// Returns the union of the cameras' areas.
Area ComputeJoinedArea(const std::vector<CameraFile>& cameras) {
  Area area = cameras[0].camera->area();
  for (const CameraFile& file : cameras) {
    const Area& own = file.camera->area();
    area.Extend({own.x0, own.y0});
    area.Extend({own.x1, own.y1});
  }
  return area;
}

// Returns the coordinate-wise median, if most of the units have values.
std::optional<Eigen::Vector2d> ComputeMajorityMedian(
    const std::vector<PixelField>& units, size_t pixel) {
  std::vector<double> x, y;
  for (const PixelField& unit : units)
    if (const auto& value = unit[pixel]) {
      x.push_back(value->x());
      y.push_back(value->y());
    }
  if (2 * x.size() <= units.size()) return std::nullopt;
  return Eigen::Vector2d(Median(x), Median(y));
}

// Fits a grid to the medians; nullopt if there are no medians.
std::optional<BSplineSurface> MedianSurface(
    const BSplineSurface& grid, const std::vector<Eigen::Vector2d>& pixels,
    const std::vector<PixelField>& units) {
  std::vector<SurfaceSample> samples;
  for (size_t i = 0; i < pixels.size(); ++i)
    if (const auto value = ComputeMajorityMedian(units, i))
      samples.push_back({pixels[i], *value});
  if (samples.empty()) return std::nullopt;
  return FitSurface(grid.area(), grid.columns(), grid.rows(), samples);
}

// Returns the directions of pixels in the chart.
PixelField ComputeChart(const CameraModel& camera,
                        const std::vector<Eigen::Vector2d>& pixels) {
  PixelField values;
  for (const Eigen::Vector2d& pixel : pixels) {
    const auto ray = camera.Unproject(pixel);
    values.push_back(ray ? std::optional(ToChart(*ray)) : std::nullopt);
  }
  return values;
}

// The polynomials' degree in each coordinate.
constexpr int kDegree = 5, kNumPolynomials = NumPolynomials(kDegree);
using Polynomials = Eigen::Matrix<double, kNumPolynomials, 1>;
using SmoothFit = Eigen::Matrix<double, kNumPolynomials, 2>;

// Fits polynomials to displacements. The fit is robust against poor
// extrapolation: values far from it have a low weight.
SmoothFit FitSmooth(const PixelField& displacements,
                    const std::vector<Polynomials>& polynomials) {
  constexpr int kRounds = 15;
  constexpr double kMinScalePx = 0.1;
  const auto count = std::count_if(displacements.begin(), displacements.end(),
                                   [](const auto& d) { return d.has_value(); });
  Eigen::MatrixXd basis(count, kNumPolynomials), values(count, 2);
  for (size_t i = 0, row = 0; i < displacements.size(); ++i) {
    if (!displacements[i]) continue;
    basis.row(row) = polynomials[i];
    values.row(row++) = *displacements[i];
  }
  SmoothFit fit = SmoothFit::Zero();
  double far_px = INFINITY;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::VectorXd sizes = (values - basis * fit).rowwise().norm();
    const Eigen::VectorXd weights =
        (1 + (sizes / far_px).array().square()).inverse();
    const Eigen::MatrixXd weighted = weights.asDiagonal() * basis;
    Eigen::MatrixXd square = basis.transpose() * weighted;
    square.diagonal().array() += 1e-9;
    fit = square.llt().solve(weighted.transpose() * values);
    // sizes are the residuals of the previous round; they are not available in
    // the first round.
    if (round > 0)
      far_px = std::max(kMinScalePx, Median({sizes.begin(), sizes.end()}));
  }
  return fit;
}

// Marks the units without large deviations at any pixel.
std::vector<bool> SelectInliers(const std::vector<SmoothFit>& fits,
                                const std::vector<Polynomials>& polynomials) {
  constexpr double kMaxRatio = 5;
  constexpr double kMinPx = 0.5;
  constexpr size_t kEachPixel = 17;  // subsampling suffices
  std::vector<bool> is_inlier(fits.size(), true);
  for (size_t i = 0; i < polynomials.size(); i += kEachPixel) {
    std::vector<double> x, y, distances;
    for (const SmoothFit& fit : fits) {
      const Eigen::Vector2d moved = fit.transpose() * polynomials[i];
      x.push_back(moved.x());
      y.push_back(moved.y());
    }
    const Eigen::Vector2d center(Median(x), Median(y));
    for (size_t u = 0; u < fits.size(); ++u)
      distances.push_back((Eigen::Vector2d(x[u], y[u]) - center).norm());
    std::vector<double> sorted = distances;
    std::sort(sorted.begin(), sorted.end());
    const double limit_px =
        kMaxRatio * std::max(kMinPx, sorted[3 * sorted.size() / 4]);
    for (size_t u = 0; u < fits.size(); ++u)
      if (distances[u] > limit_px) is_inlier[u] = false;
  }
  return is_inlier;
}

SmoothFit ComputeInlierMean(const std::vector<SmoothFit>& fits,
                            const std::vector<bool>& is_inlier) {
  SmoothFit sum = SmoothFit::Zero();
  double count = 0;
  for (size_t u = 0; u < fits.size(); ++u) {
    if (!is_inlier[u]) continue;
    sum += fits[u];
    ++count;
  }
  return count > 0 ? SmoothFit(sum / count) : sum;
}

// Shifts a reference to the population mean. The smooth differences between
// lenses exceed their errors, and are averaged, since a median would switch
// between units from pixel to pixel. For the remainder, the median is used.
// Returns the units that were averaged.
BSplineSurface MoveToMean(const CentralGeneric& reference,
                          const std::vector<CameraFile>& cameras,
                          const std::vector<Eigen::Vector2d>& pixels,
                          std::vector<bool>* is_inlier) {
  std::vector<Polynomials> polynomials;
  for (const Eigen::Vector2d& pixel : pixels)
    polynomials.push_back(
        EvaluatePolynomials(reference.area(), pixel, kDegree));
  std::vector<SmoothFit> fits;
  std::vector<PixelField> residual_fields;
  for (const CameraFile& file : cameras) {
    PixelField& rest = residual_fields.emplace_back(
        ComputeDisplacements(reference, *file.camera, pixels));
    const SmoothFit fit = FitSmooth(rest, polynomials);
    for (size_t i = 0; i < pixels.size(); ++i)
      if (rest[i]) *rest[i] -= fit.transpose() * polynomials[i];
    fits.push_back(fit);
  }
  *is_inlier = SelectInliers(fits, polynomials);
  const SmoothFit mean = ComputeInlierMean(fits, *is_inlier);
  std::vector<SurfaceSample> samples;
  for (size_t i = 0; i < pixels.size(); ++i)
    if (const auto rest = ComputeMajorityMedian(residual_fields, i))
      samples.push_back(
          {pixels[i],
           reference.surface().Evaluate(
               pixels[i] + mean.transpose() * polynomials[i] + *rest)});
  const BSplineSurface& grid = reference.surface();
  if (samples.empty()) return grid;
  return FitSurface(grid.area(), grid.columns(), grid.rows(), samples);
}

}  // namespace

std::optional<CameraFile> ComputeMeanCamera(
    const FleetAnalysis& fleet, const std::vector<std::string>& folders) {
  if (fleet.statistics.charts.empty()) return std::nullopt;
  return ComputeMeanCamera(SelectInlierCameras(fleet, folders));
}

std::optional<CameraFile> ComputeMeanCamera(
    const std::vector<CameraFile>& cameras) {
  if (cameras.empty()) return std::nullopt;
  // A knot spacing of 1/32 of the image's width.
  constexpr int kColumns = 35, kSamplesPerCell = 3;
  const Area area = ComputeJoinedArea(cameras);
  const int rows =
      std::max(7, static_cast<int>(kColumns * area.height() / area.width()));
  const BSplineSurface grid(area, kColumns, rows);
  const std::vector<Eigen::Vector2d> pixels =
      grid.SamplePixels(kSamplesPerCell);
  std::vector<PixelField> charts;
  for (const CameraFile& file : cameras)
    charts.push_back(ComputeChart(*file.camera, pixels));
  const auto first = MedianSurface(grid, pixels, charts);
  if (!first) return std::nullopt;
  const ImageSize size = cameras[0].camera->image_size();
  std::vector<bool> is_inlier;
  CameraFile file;
  file.camera = std::make_shared<CentralGeneric>(
      size,
      MoveToMean(CentralGeneric(size, *first), cameras, pixels, &is_inlier));
  std::vector<CameraFile> inliers;
  for (size_t u = 0; u < cameras.size(); ++u)
    if (is_inlier[u]) inliers.push_back(cameras[u]);
  file.spread = EstimatePopulationCovariance(*file.camera, inliers);
  file.name = fmt::format("mean of {} units", cameras.size());
  return file;
}

}  // namespace raygrid
