#include "packing/inverse_grid.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace raygrid {
namespace {

// Of the longer side: as many as bring the start close enough, from few on.
constexpr std::array<int, 7> kLongerSideCells = {6, 8, 10, 13, 16, 20, 24};
constexpr double kCloseEnoughPx = 1.0 / 32;
constexpr double kCloseEnoughSlope = 0.02;  // relative
constexpr int kEdgeSamples = 400;
constexpr int kInnerSamples = 80;
// Chart positions have magnitudes below 4, and pixels below 16384.
constexpr double kMaxChart = 4;
constexpr double kMaxPixel = 16000;

// Pixels by chart position, of those that count.
class SurfaceSampling {
 public:
  SurfaceSampling(const BSplineSurface& surface, const TrustMask* trusted)
      : surface_(surface), trusted_(trusted) {
    for (int j = 0; j <= kInnerSamples; ++j)
      for (int i = 0; i <= kInnerSamples; ++i)
        handedness_ += HandednessAt(PixelAt(Part(i), Part(j)));
  }

  // The area's edge densely, its inside more coarsely.
  std::vector<SurfaceSample> Samples() const {
    std::vector<SurfaceSample> samples;
    for (int k = 0; k <= kEdgeSamples; ++k) {
      const double t = static_cast<double>(k) / kEdgeSamples;
      Add(t, 0, &samples);
      Add(t, 1, &samples);
      Add(0, t, &samples);
      Add(1, t, &samples);
    }
    for (int j = 1; j < kInnerSamples; ++j)
      for (int i = 1; i < kInnerSamples; ++i) Add(Part(i), Part(j), &samples);
    return samples;
  }

 private:
  static double Part(int index) {
    return static_cast<double>(index) / kInnerSamples;
  }
  Eigen::Vector2d PixelAt(double u, double v) const {
    const Area& area = surface_.area();
    return {area.x0 + u * area.width(), area.y0 + v * area.height()};
  }
  // +1 or -1; the other one where the surface is folded.
  int HandednessAt(const Eigen::Vector2d& pixel) const {
    Eigen::Matrix2d derivative;
    surface_.Evaluate(pixel, &derivative);
    return derivative.determinant() < 0 ? -1 : 1;
  }
  void Add(double u, double v, std::vector<SurfaceSample>* samples) const {
    const Eigen::Vector2d pixel = PixelAt(u, v);
    const Eigen::Vector2d chart = surface_.Evaluate(pixel);
    if ((trusted_ && !trusted_->Trusts(pixel)) ||
        HandednessAt(pixel) * handedness_ < 0 ||
        chart.cwiseAbs().maxCoeff() > kMaxChart)
      return;
    // What is found by chart position is the pixel.
    samples->push_back({chart, pixel});
  }

  const BSplineSurface& surface_;
  const TrustMask* const trusted_;
  int handedness_ = 0;  // of most of the surface, by sign
};

// A rectangle of the chart around all samples.
Area ChartAround(const std::vector<SurfaceSample>& samples) {
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

BSplineSurface FitInverse(const Area& chart, int longer_side_cells,
                          const std::vector<SurfaceSample>& samples) {
  const double cell =
      std::max(chart.width(), chart.height()) / longer_side_cells;
  return FitSurface(chart, NumControlPoints(chart.width(), cell),
                    NumControlPoints(chart.height(), cell), samples);
}

// Whether one step from the inverse's pixel, with its derivative, is enough
// everywhere.
bool IsCloseEnough(const BSplineSurface& surface, const BSplineSurface& inverse,
                   const std::vector<SurfaceSample>& samples) {
  return std::all_of(
      samples.begin(), samples.end(), [&](const SurfaceSample& sample) {
        Eigen::Matrix2d there, back;
        surface.Evaluate(sample.value, &there);
        const Eigen::Vector2d pixel = inverse.Evaluate(sample.pixel, &back);
        return (pixel - sample.value).norm() <= kCloseEnoughPx &&
               (back * there - Eigen::Matrix2d::Identity()).norm() <=
                   kCloseEnoughSlope;
      });
}

// c |c| of the widest sample, less a little.
double CosineLimit(const std::vector<SurfaceSample>& samples) {
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

}  // namespace

std::optional<InverseGrid> MakeInverseGrid(const BSplineSurface& surface,
                                           const TrustMask* trusted) {
  const std::vector<SurfaceSample> samples =
      SurfaceSampling(surface, trusted).Samples();
  if (samples.empty()) return std::nullopt;
  const Area chart = ChartAround(samples);
  BSplineSurface fit;
  for (const int cells : kLongerSideCells) {
    fit = FitInverse(chart, cells, samples);
    if (IsCloseEnough(surface, fit, samples)) break;
  }
  const std::optional<NarrowGrid> points = Narrow(Quantize(fit));
  if (!points) return std::nullopt;
  InverseGrid inverse;
  inverse.points = *points;
  rg_inverse_section& s = inverse.section;
  s.a0_q27 = FixedPoint(chart.x0, 27);
  s.b0_q27 = FixedPoint(chart.y0, 27);
  s.a1_q27 = FixedPoint(chart.x1, 27);
  s.b1_q27 = FixedPoint(chart.y1, 27);
  s.columns = static_cast<uint16_t>(fit.columns());
  s.rows = static_cast<uint16_t>(fit.rows());
  s.scale_a_q21 = rg_grid_scale_q32(s.columns - 3u,
                                    static_cast<uint32_t>(s.a1_q27 - s.a0_q27));
  s.scale_b_q21 = rg_grid_scale_q32(s.rows - 3u,
                                    static_cast<uint32_t>(s.b1_q27 - s.b0_q27));
  s.cos_limit_q30 = FixedPoint(CosineLimit(samples), 30);
  return inverse;
}

}  // namespace raygrid
