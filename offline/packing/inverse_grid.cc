#include "packing/inverse_grid.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

namespace raygrid {
namespace {

// The numbers of cells along the longer side; above kMaxRefinableCells only if
// valid pixels require it.
constexpr int kNumCells[] = {6, 8, 10, 13, 16, 20, 24, 32, 40, 48, 64};
constexpr int kMaxRefinableCells = 24;
// With an initial error below this, one Newton step reaches the runtime's
// accuracy.
constexpr double kTolerancePx = 1.0 / 32;
constexpr double kSlopeTolerance = 0.02;  // relative
// About three samples per cell along each axis.
constexpr int kSamplesAcross = 200;
constexpr int kEdgeSamples = 1000;
// Valid pixels outweigh the others if both cannot be fitted.
constexpr double kInvalidPixelWeight = 0.01;
// Relative to the samples' weight: negligible for supported control points, but
// keeps unsupported ones in range.
constexpr double kSmoothness = 1e-4;
// The absolute values of chart positions are below 4, those of pixel
// coordinates below 16384.
constexpr double kMaxChart = 4;
constexpr double kMaxPixel = 16000;
constexpr double kMinPixels = 3e4, kMaxPixels = 1e6;

// Pixels as a function of chart position.
struct InverseSamples {
  std::vector<SurfaceSample> valid_region, others;
};

// Samples of a surface, except where it folds.
class SurfaceSampling {
 public:
  SurfaceSampling(const BSplineSurface& surface,
                  const ValidityMask* valid_region)
      : surface_(surface),
        valid_region_(valid_region),
        handedness_(ComputeDominantHandedness(surface)) {}

  // Samples the area's edge densely and its interior more coarsely.
  InverseSamples Samples() const {
    InverseSamples samples;
    for (int k = 0; k <= kEdgeSamples; ++k) {
      const double t = static_cast<double>(k) / kEdgeSamples;
      for (const Eigen::Vector2d& part :
           {Eigen::Vector2d(t, 0), Eigen::Vector2d(t, 1), Eigen::Vector2d(0, t),
            Eigen::Vector2d(1, t)})
        Add(part, &samples);
    }
    for (int j = 1; j < kSamplesAcross; ++j)
      for (int i = 1; i < kSamplesAcross; ++i)
        Add(Eigen::Vector2d(i, j) / kSamplesAcross, &samples);
    return samples;
  }

 private:
  void Add(const Eigen::Vector2d& part, InverseSamples* samples) const {
    const Area& area = surface_.area();
    const Eigen::Vector2d pixel(area.x0 + part.x() * area.width(),
                                area.y0 + part.y() * area.height());
    Eigen::Matrix2d derivative;
    const Eigen::Vector2d chart = surface_.Evaluate(pixel, &derivative);
    if (derivative.determinant() * handedness_ <= 0 ||
        chart.cwiseAbs().maxCoeff() > kMaxChart)
      return;
    if (!valid_region_ || valid_region_->IsValidAt(pixel))
      samples->valid_region.push_back({chart, pixel, 1});
    else
      samples->others.push_back({chart, pixel, kInvalidPixelWeight});
  }

  const BSplineSurface& surface_;
  const ValidityMask* const valid_region_;
  const int handedness_;
};

// Returns the bounding rectangle of all samples in the chart.
Area ComputeChartArea(const std::vector<SurfaceSample>& samples) {
  Eigen::Array2d low = samples.front().pixel, high = low;
  for (const SurfaceSample& sample : samples) {
    low = low.min(sample.pixel.array());
    high = high.max(sample.pixel.array());
  }
  const double margin = (high - low).maxCoeff() / 40;
  low = (low - margin).max(-kMaxChart);
  high = (high + margin).min(kMaxChart);
  return {low.x(), low.y(), high.x(), high.y()};
}

// Returns c |c| for the cosine c of the sample farthest off axis, with a
// margin.
double ComputeCosineLimit(const std::vector<SurfaceSample>& samples) {
  double cosine = 1;
  for (const SurfaceSample& sample : samples) {
    const double s = sample.pixel.squaredNorm();
    cosine = std::min(cosine, (1 - s) / (1 + s));
  }
  return std::max(cosine * std::abs(cosine) - 1e-3, -1.0);
}

int32_t FixedPoint(double value, int bits) {
  return static_cast<int32_t>(std::lround(std::ldexp(value, bits)));
}

ControlPoints Quantize(const BSplineSurface& inverse) {
  ControlPoints points = {inverse.columns(), inverse.rows(), {}};
  for (const Eigen::Vector2d& pixel : inverse.points())
    for (int c = 0; c < 2; ++c)
      points.values.push_back(FixedPoint(
          std::clamp(pixel[c], -kMaxPixel, kMaxPixel), RG_INVERSE_PIXEL_BITS));
  return points;
}

// Fits the inverse of a surface over a rectangle of the chart.
class InverseFitting {
 public:
  InverseFitting(const BSplineSurface& surface, const Area& chart,
                 std::vector<SurfaceSample> samples)
      : surface_(surface), chart_(chart), samples_(std::move(samples)) {}

  BSplineSurface Fit(int longer_side_cells) const {
    const double cell =
        std::max(chart_.width(), chart_.height()) / longer_side_cells;
    return FitSurface(chart_, NumControlPoints(chart_.width(), cell),
                      NumControlPoints(chart_.height(), cell), samples_,
                      kSmoothness);
  }

  // Returns nullopt if 16 bits cannot represent the grid.
  std::optional<InverseGrid> QuantizeInverseGrid(
      const BSplineSurface& fit,
      uint32_t max_fraction_bits = RG_NARROW_MAX_BITS) const {
    const std::optional<Int16Grid> points =
        QuantizeToInt16(Quantize(fit), max_fraction_bits);
    if (!points) return std::nullopt;
    InverseGrid inverse;
    inverse.points = *points;
    rg_inverse_section& s = inverse.section;
    s.a0_q27 = FixedPoint(chart_.x0, 27);
    s.b0_q27 = FixedPoint(chart_.y0, 27);
    s.a1_q27 = FixedPoint(chart_.x1, 27);
    s.b1_q27 = FixedPoint(chart_.y1, 27);
    s.columns = static_cast<uint16_t>(fit.columns());
    s.rows = static_cast<uint16_t>(fit.rows());
    s.scale_a_q21 = rg_grid_scale_q32(
        s.columns - 3u, static_cast<uint32_t>(s.a1_q27 - s.a0_q27));
    s.scale_b_q21 = rg_grid_scale_q32(
        s.rows - 3u, static_cast<uint32_t>(s.b1_q27 - s.b0_q27));
    s.cos_limit_q30 = FixedPoint(ComputeCosineLimit(samples_), 30);
    return inverse;
  }

  // Whether one Newton step from the inverse's pixel, with its Jacobian,
  // suffices for all samples.
  bool IsWithinTolerance(const BSplineSurface& inverse,
                         const std::vector<SurfaceSample>& samples) const {
    return std::all_of(
        samples.begin(), samples.end(), [&](const SurfaceSample& sample) {
          Eigen::Matrix2d there, back;
          surface_.Evaluate(sample.value, &there);
          const Eigen::Vector2d pixel = inverse.Evaluate(sample.pixel, &back);
          return (pixel - sample.value).norm() <= kTolerancePx &&
                 (back * there - Eigen::Matrix2d::Identity()).norm() <=
                     kSlopeTolerance;
        });
  }

 private:
  const BSplineSurface& surface_;
  const Area chart_;
  const std::vector<SurfaceSample> samples_;
};

bool IsBetter(const EvaluatedInverseGrid& a, const EvaluatedInverseGrid& b) {
  const auto faults = [](const EvaluatedInverseGrid& inverse) {
    return std::make_tuple(inverse.error.valid_region.FailedFraction(),
                           inverse.error.others.FailedFraction(),
                           !inverse.is_close);
  };
  return faults(a) < faults(b);
}

// Searches the number of cells; replaces *best if an inverse is better. Most
// candidates are rejected by evaluating a few pixels only.
void SearchCells(const InverseFitting& fitting,
                 const std::vector<SurfaceSample>& valid_region,
                 const InverseGridEvaluator& measure,
                 std::optional<EvaluatedInverseGrid>* best) {
  for (const int cells : kNumCells) {
    if (cells > kMaxRefinableCells && *best &&
        (*best)->error.valid_region.AreAllAccurate())
      return;
    const BSplineSurface fit = fitting.Fit(cells);
    const std::optional<InverseGrid> grid = fitting.QuantizeInverseGrid(fit);
    if (!grid) continue;
    std::optional<ProjectionError> error = measure(*grid, kMinPixels);
    if (error && error->valid_region.AreAllAccurate())
      error = measure(*grid, kMaxPixels);
    if (!error) continue;
    const EvaluatedInverseGrid made = {
        *grid, *error, fitting.IsWithinTolerance(fit, valid_region)};
    if (*best && !IsBetter(made, **best)) continue;
    *best = made;
    if (made.is_close && error->valid_region.AreAllAccurate() &&
        error->others.AreAllAccurate())
      return;
  }
}

}  // namespace

std::optional<EvaluatedInverseGrid> FitInverseGrid(
    const BSplineSurface& surface, const ValidityMask* valid_region,
    const InverseGridEvaluator& measure) {
  const InverseSamples samples =
      SurfaceSampling(surface, valid_region).Samples();
  if (samples.valid_region.empty()) return std::nullopt;
  std::vector<SurfaceSample> all = samples.valid_region;
  all.insert(all.end(), samples.others.begin(), samples.others.end());
  std::optional<EvaluatedInverseGrid> best;
  const Area chart = ComputeChartArea(all);
  SearchCells({surface, chart, all}, samples.valid_region, measure, &best);
  if (!best || !best->error.valid_region.AreAllAccurate()) {
    const Area near = ComputeChartArea(samples.valid_region);
    std::vector<SurfaceSample> around;
    std::copy_if(all.begin(), all.end(), std::back_inserter(around),
                 [&](const SurfaceSample& sample) {
                   return near.Contains(sample.pixel);
                 });
    if (around.size() < all.size())
      SearchCells({surface, near, around}, samples.valid_region, measure,
                  &best);
  }
  if (best) best->error = *measure(best->grid, kMaxPixels);
  return best;
}

namespace {

// Returns the inverses of several surfaces with this number of cells and a
// common layout; nullopt if 16 bits cannot represent one of them.
std::optional<std::vector<EvaluatedInverseGrid>> FitJointly(
    const std::vector<InverseFitting>& fittings,
    const std::vector<InverseSamples>& samples, int cells) {
  std::vector<BSplineSurface> fits;
  std::vector<EvaluatedInverseGrid> made;
  uint32_t bits = RG_NARROW_MAX_BITS;
  int32_t cos_limit_q30 = INT32_MAX;
  for (size_t k = 0; k < fittings.size(); ++k) {
    fits.push_back(fittings[k].Fit(cells));
    const std::optional<InverseGrid> grid =
        fittings[k].QuantizeInverseGrid(fits.back());
    if (!grid) return std::nullopt;
    bits = std::min(bits, grid->points.section.fraction_bits);
    cos_limit_q30 = std::min(cos_limit_q30, grid->section.cos_limit_q30);
  }
  for (size_t k = 0; k < fittings.size(); ++k) {
    std::optional<InverseGrid> grid =
        fittings[k].QuantizeInverseGrid(fits[k], bits);
    if (!grid) return std::nullopt;
    grid->section.cos_limit_q30 = cos_limit_q30;
    made.push_back(
        {*std::move(grid),
         {},
         fittings[k].IsWithinTolerance(fits[k], samples[k].valid_region)});
  }
  return made;
}

// Returns the sum of the fractions of pixels that the inverses miss; ties are
// resolved in favour of inverses that need a single step.
double FailedFraction(const std::vector<EvaluatedInverseGrid>& inverses) {
  double missed = 0;
  for (const EvaluatedInverseGrid& inverse : inverses)
    missed += inverse.error.valid_region.FailedFraction() +
              (inverse.is_close ? 0 : 1e-9);
  return missed;
}

}  // namespace

std::optional<std::vector<EvaluatedInverseGrid>> FitInverseGridsJointly(
    const std::vector<const BSplineSurface*>& surfaces,
    const ValidityMask* valid_region,
    const SingleInverseGridEvaluator& measure) {
  std::vector<InverseSamples> samples;
  std::vector<SurfaceSample> all;
  for (const BSplineSurface* surface : surfaces) {
    samples.push_back(SurfaceSampling(*surface, valid_region).Samples());
    if (samples.back().valid_region.empty()) return std::nullopt;
    for (const auto* some :
         {&samples.back().valid_region, &samples.back().others})
      all.insert(all.end(), some->begin(), some->end());
  }
  const Area chart = ComputeChartArea(all);
  std::vector<InverseFitting> fittings;
  for (size_t k = 0; k < surfaces.size(); ++k) {
    std::vector<SurfaceSample> own = samples[k].valid_region;
    own.insert(own.end(), samples[k].others.begin(), samples[k].others.end());
    fittings.emplace_back(*surfaces[k], chart, std::move(own));
  }
  std::optional<std::vector<EvaluatedInverseGrid>> best;
  for (const int cells : kNumCells) {
    if (cells > kMaxRefinableCells) break;
    std::optional<std::vector<EvaluatedInverseGrid>> made =
        FitJointly(fittings, samples, cells);
    if (!made) continue;
    bool is_measured = true;
    for (size_t k = 0; k < made->size() && is_measured; ++k) {
      const auto error = measure(k, (*made)[k].grid, kMaxPixels);
      is_measured = error.has_value();
      if (error) (*made)[k].error = *error;
    }
    if (!is_measured ||
        (best && FailedFraction(*made) >= FailedFraction(*best)))
      continue;
    best = std::move(made);
    if (FailedFraction(*best) == 0) break;
  }
  return best;
}

}  // namespace raygrid
