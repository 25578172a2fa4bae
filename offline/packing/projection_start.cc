#include "packing/projection_start.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

constexpr int kLongerSideCells = 20;
// Parts of a cell that the samples' distance is well below.
constexpr double kCellMargin = 0.05;
constexpr int kEdgeSamples = 1600;
constexpr int kInnerSamples = 80;

struct Sample {
  Eigen::Vector2d pixel, chart;
};

void AddSample(const BSplineSurface& surface, double u, double v,
               std::vector<Sample>* samples) {
  const Area& area = surface.area();
  const Eigen::Vector2d pixel(area.x0 + u * area.width(),
                              area.y0 + v * area.height());
  samples->push_back({pixel, surface.Evaluate(pixel)});
}

// The area's edge densely, its inside more coarsely.
std::vector<Sample> SampleSurface(const BSplineSurface& surface) {
  std::vector<Sample> samples;
  for (int k = 0; k <= kEdgeSamples; ++k) {
    const double t = static_cast<double>(k) / kEdgeSamples;
    AddSample(surface, t, 0, &samples);
    AddSample(surface, t, 1, &samples);
    AddSample(surface, 0, t, &samples);
    AddSample(surface, 1, t, &samples);
  }
  for (int j = 1; j < kInnerSamples; ++j)
    for (int i = 1; i < kInnerSamples; ++i)
      AddSample(surface, static_cast<double>(i) / kInnerSamples,
                static_cast<double>(j) / kInnerSamples, &samples);
  return samples;
}

// The equal cells of the chart.
struct ChartCells {
  Eigen::Array2d low, high;
  Eigen::Array2i count;

  Eigen::Array2d At(double i, double j) const {
    return low + (high - low) * Eigen::Array2d(i, j) / count.cast<double>();
  }
};

ChartCells CutChart(const std::vector<Sample>& samples) {
  ChartCells cells;
  cells.low = cells.high = samples.front().chart;
  for (const Sample& sample : samples) {
    cells.low = cells.low.min(sample.chart.array());
    cells.high = cells.high.max(sample.chart.array());
  }
  const Eigen::Array2d extent = cells.high - cells.low;
  const double cell = extent.maxCoeff() / (kLongerSideCells - 1);
  cells.low = (cells.low - cell / 2).max(-4);
  cells.high = (cells.high + cell / 2).min(4);
  cells.count = ((cells.high - cells.low) / cell).ceil().cast<int>().max(1);
  return cells;
}

// The cells that samples fall into, row by row.
std::vector<bool> FindLiveCells(const std::vector<Sample>& samples,
                                const ChartCells& cells) {
  std::vector<bool> live(cells.count.prod(), false);
  for (const Sample& sample : samples) {
    const Eigen::Array2d position = (sample.chart.array() - cells.low) /
                                    (cells.high - cells.low) *
                                    cells.count.cast<double>();
    for (double dy : {-kCellMargin, kCellMargin}) {
      for (double dx : {-kCellMargin, kCellMargin}) {
        const Eigen::Array2i cell = (position + Eigen::Array2d(dx, dy))
                                        .floor()
                                        .cast<int>()
                                        .max(0)
                                        .min(cells.count - 1);
        live[cell.y() * cells.count.x() + cell.x()] = true;
      }
    }
  }
  return live;
}

bool IsVertexLive(const std::vector<bool>& live, const ChartCells& cells, int i,
                  int j) {
  for (int y = std::max(j - 1, 0); y <= std::min(j, cells.count.y() - 1); ++y)
    for (int x = std::max(i - 1, 0); x <= std::min(i, cells.count.x() - 1); ++x)
      if (live[y * cells.count.x() + x]) return true;
  return false;
}

// About the pixel of a chart position: the nearest sample's tangent plane.
Eigen::Vector2d Extrapolate(const BSplineSurface& surface,
                            const std::vector<Sample>& samples,
                            const Eigen::Vector2d& chart) {
  const auto nearest =
      std::min_element(samples.begin(), samples.end(),
                       [&chart](const Sample& a, const Sample& b) {
                         return (a.chart - chart).squaredNorm() <
                                (b.chart - chart).squaredNorm();
                       });
  Eigen::Matrix2d derivative;
  surface.Evaluate(nearest->pixel, &derivative);
  if (!(std::abs(derivative.determinant()) > 1e-18)) return nearest->pixel;
  const Eigen::Vector2d step = derivative.inverse() * (chart - nearest->chart);
  const double limit = surface.area().width() / 4;
  return nearest->pixel + step * std::min(1.0, limit / (step.norm() + 1e-9));
}

int16_t HalfPixels(double pixels) {
  return static_cast<int16_t>(
      std::clamp(std::lround(2 * pixels), -32767L, 32767L));
}

// c |c| of the widest sample, less a little.
double CosineLimit(const std::vector<Sample>& samples) {
  double cosine = 1;
  for (const Sample& sample : samples) {
    const double s = sample.chart.squaredNorm();
    cosine = std::min(cosine, (1 - s) / (1 + s));
  }
  return std::max(cosine * std::abs(cosine) - 1e-3, -1.0);
}

int32_t FixedPoint(double value, int bits) {
  return static_cast<int32_t>(std::lround(std::ldexp(value, bits)));
}

}  // namespace

ProjectionStart MakeProjectionStart(const BSplineSurface& surface) {
  const std::vector<Sample> samples = SampleSurface(surface);
  const ChartCells cells = CutChart(samples);
  const std::vector<bool> live = FindLiveCells(samples, cells);
  ProjectionStart start;
  rg_start_section& s = start.section;
  s.a0_q28 = FixedPoint(cells.low.x(), 28);
  s.b0_q28 = FixedPoint(cells.low.y(), 28);
  s.a1_q28 = FixedPoint(cells.high.x(), 28);
  s.b1_q28 = FixedPoint(cells.high.y(), 28);
  s.columns = static_cast<uint16_t>(cells.count.x() + 1);
  s.rows = static_cast<uint16_t>(cells.count.y() + 1);
  s.scale_a_q20 = rg_grid_scale_q32(s.columns - 1u,
                                    static_cast<uint32_t>(s.a1_q28) - s.a0_q28);
  s.scale_b_q20 = rg_grid_scale_q32(s.rows - 1u,
                                    static_cast<uint32_t>(s.b1_q28) - s.b0_q28);
  s.cos_limit_q30 = FixedPoint(CosineLimit(samples), 30);
  for (int j = 0; j < s.rows; ++j) {
    for (int i = 0; i < s.columns; ++i) {
      const bool is_live = IsVertexLive(live, cells, i, j);
      const Eigen::Vector2d pixel =
          is_live ? Extrapolate(surface, samples, cells.At(i, j).matrix())
                  : Eigen::Vector2d::Zero();
      start.vertices.push_back(is_live ? HalfPixels(pixel.x()) : RG_NO_VERTEX);
      start.vertices.push_back(HalfPixels(pixel.y()));
    }
  }
  return start;
}

}  // namespace raygrid
