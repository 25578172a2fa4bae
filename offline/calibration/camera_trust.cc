#include "calibration/camera_trust.h"

#include <algorithm>
#include <cmath>

#include "adjustment/covariance.h"
#include "camera/parametric_model.h"

namespace raygrid {
namespace {

// A cell is trusted with so small a standard deviation, as a part of the
// noise's. At 0.5, four standard deviations of a pixel are twice the noise.
constexpr double kTrustedPart = 0.5;
// And with so many features within so many cells to all sides.
constexpr int kMinFeatures = 3, kNearCells = 2;

// About square, and not more than a blob can hold.
UncertaintyOptions LatticeOver(const Area& area) {
  constexpr int kIntervals = 16;
  const double longer = std::max(area.width(), area.height());
  const auto count = [longer](double extent) {
    return 1 + std::max(1, static_cast<int>(
                               std::lround(kIntervals * extent / longer)));
  };
  UncertaintyOptions options;
  options.columns = count(area.width());
  options.rows = count(area.height());
  return options;
}

// Features in each cell.
std::vector<int> CountFeatures(const Adjusted& adjusted, int camera,
                               const TrustMask& mask) {
  std::vector<int> counts(mask.is_trusted.size(), 0);
  for (const View& view : adjusted.problem.views) {
    if (view.camera != camera) continue;
    for (const Observation& observation : view.observations)
      ++counts[mask.CellOf(observation.pixel)];
  }
  return counts;
}

int CountNear(const std::vector<int>& counts, const TrustMask& mask, int cell) {
  const int column = cell % mask.columns, row = cell / mask.columns;
  int sum = 0;
  for (int j = std::max(row - kNearCells, 0);
       j <= std::min(row + kNearCells, mask.rows - 1); ++j)
    for (int i = std::max(column - kNearCells, 0);
         i <= std::min(column + kNearCells, mask.columns - 1); ++i)
      sum += counts[j * mask.columns + i];
  return sum;
}

TrustMask MaskOf(const Adjusted& adjusted, int camera,
                 const DeviationLattice& lattice, double max_deviation_px) {
  const CameraModel& model = *adjusted.state.cameras[camera];
  const Area& area = model.area();
  TrustMask mask = TrustMask::Over(model.image_size());
  const std::vector<int> counts = CountFeatures(adjusted, camera, mask);
  for (int cell = 0; cell < mask.columns * mask.rows; ++cell) {
    const Eigen::Vector2d center = mask.CellCenter(cell);
    const Eigen::Vector2d nearest(std::clamp(center.x(), area.x0, area.x1),
                                  std::clamp(center.y(), area.y0, area.y1));
    const bool is_known = lattice.At(area, nearest) <= max_deviation_px;
    mask.is_trusted[cell] =
        is_known && CountNear(counts, mask, cell) >= kMinFeatures;
  }
  return mask;
}

// An uncalibrated lens's: its focal lengths and centre are anywhere.
CameraPrior UncalibratedPrior(const ParametricModel& lens, const Area& area,
                              double noise_px) {
  constexpr double kDistortionPx = 30;
  CameraPrior prior = DistortionPrior(lens, area);
  for (PriorGroup& group : prior.groups)
    group.weight = std::pow(noise_px / kDistortionPx, 2);
  PriorGroup linear;
  const int count = lens.NumParameters();
  linear.precision.resize(count, count);
  for (int k = 0; k < 4; ++k) linear.precision.insert(k, k) = 1;
  linear.weight = std::pow(noise_px / area.width(), 2);
  prior.groups.push_back(linear);
  return prior;
}

// Standard deviations of the lens that a grid's prior is centred on, its
// distortion as little known as an uncalibrated lens's. What no view tells of
// it, such as the focal length where no board is tilted, the grid takes over,
// and its prior holds it; zero if there is no such lens.
std::vector<double> LensDeviations(const Adjusted& adjusted, int camera,
                                   const UncertaintyOptions& size,
                                   AdjustmentOptions options) {
  std::vector<double> deviations(size.columns * size.rows, 0.0);
  if (adjusted.lenses.empty()) return deviations;
  const double noise_px = adjusted.summary.noise_px;
  const Area area = adjusted.state.cameras[camera]->area();
  AdjustmentState state = adjusted.state;
  const auto lens =
      dynamic_cast<const ParametricModel&>(*adjusted.lenses[camera])
          .OverArea(area);
  state.cameras[camera] = lens->Clone();
  GaussianPrior prior = adjusted.prior;
  prior.cameras[camera] = UncalibratedPrior(*lens, area, noise_px);
  options.fix_points = true;
  options.huber_px = INFINITY;  // the lens need not fit
  const std::vector<PixelUncertainty> pixels = ProjectionUncertainty(
      adjusted.problem.views, prior, options, noise_px, state, camera, size);
  for (size_t i = 0; i < pixels.size(); ++i) {
    const double deviation = WorseDeviation(pixels[i].total_px2);
    if (std::isfinite(deviation)) deviations[i] = deviation;
  }
  return deviations;
}

}  // namespace

std::optional<CameraUncertainty> UncertaintyOf(const Adjusted& adjusted,
                                               int camera, int num_threads) {
  const double noise_px = adjusted.summary.noise_px;
  if (!(noise_px > 0)) return std::nullopt;
  AdjustmentOptions options;
  options.num_threads = num_threads;
  options.fix_points = !HavePointsMoved(adjusted);
  const UncertaintyOptions size =
      LatticeOver(adjusted.state.cameras[camera]->area());
  const std::vector<PixelUncertainty> pixels =
      ProjectionUncertainty(adjusted.problem.views, adjusted.prior, options,
                            noise_px, adjusted.state, camera, size);
  const std::vector<double> lens =
      LensDeviations(adjusted, camera, size, options);
  DeviationLattice noise = {size.columns, size.rows, {}}, total = noise;
  for (size_t i = 0; i < pixels.size(); ++i) {
    noise.deviation_px.push_back(WorseDeviation(pixels[i].noise_px2));
    total.deviation_px.push_back(
        std::hypot(WorseDeviation(pixels[i].total_px2), lens[i]));
  }
  if (!std::isfinite(total.MedianPx())) return std::nullopt;
  CameraUncertainty uncertainty;
  uncertainty.max_deviation_px = kTrustedPart * noise_px;
  uncertainty.mask =
      MaskOf(adjusted, camera, total, uncertainty.max_deviation_px);
  // Where the prior knows more than the observations, noise is not all.
  uncertainty.lattice = noise;
  for (size_t i = 0; i < pixels.size(); ++i)
    if (!uncertainty.mask.Trusts(pixels[i].pixel))
      uncertainty.lattice.deviation_px[i] = total.deviation_px[i];
  return uncertainty;
}

}  // namespace raygrid
