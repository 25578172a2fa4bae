#include "fleet/control_chart_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "report/axis_ticks.h"
#include "report/html.h"

namespace raygrid {
namespace {

// Layout, in SVG user units.
constexpr double kLeft = 76, kRight = 884, kTop = 16, kBottom = 204;
constexpr int kWidth = 980, kHeight = 240;

// ---- Coordinates -----------------------------------------------------------

// Ordinates are values of the metric, or their natural logarithms.
struct VerticalAxis {
  bool is_logarithmic = false;
  double low = 0, high = 1;

  double At(double ordinate) const {
    return kBottom - (ordinate - low) / (high - low) * (kBottom - kTop);
  }
  double ToMetric(double ordinate) const {
    return is_logarithmic ? std::exp(ordinate) : ordinate;
  }
};

double ComputeX(double unit, size_t count) {
  return kLeft + (unit + 0.5) / static_cast<double>(count) * (kRight - kLeft);
}

// A control chart converted to ordinates.
struct DrawnChart {
  std::vector<double> values, center_line;
  double lower = 0, upper = 0;  // relative to the centre line
  bool has_middle = true;
  VerticalAxis axis = {};
};

void SpanAxis(DrawnChart* chart) {
  double low = std::numeric_limits<double>::max(), high = -low;
  const auto include = [&](double ordinate) {
    if (!std::isfinite(ordinate)) return;
    low = std::min(low, ordinate);
    high = std::max(high, ordinate);
  };
  for (const double value : chart->values) include(value);
  for (const double center_line : chart->center_line) {
    include(center_line + chart->lower);
    include(center_line + chart->upper);
  }
  const double margin =
      std::max({0.06 * (high - low), 1e-4 * std::abs(high), 1e-9});
  chart->axis.low = low - margin;
  chart->axis.high = high + margin;
}

// Converts a chart. Charts of sums of squares, which have an upper limit only,
// are logarithmic, starting at a thousandth of the limit.
DrawnChart MakeDrawnChart(const ControlChart& chart) {
  DrawnChart drawn{chart.values, chart.center_line, chart.lower, chart.upper};
  drawn.axis.is_logarithmic = chart.is_logarithm;
  if (!std::isfinite(chart.lower) && std::isfinite(chart.upper)) {
    drawn.axis.is_logarithmic = true;
    drawn.has_middle = false;
    for (double& value : drawn.values)
      value = std::log(std::max(value, 1e-3 * chart.upper));
    drawn.upper = std::log(chart.upper);
    drawn.center_line.assign(drawn.values.size(), 0);
  }
  SpanAxis(&drawn);
  return drawn;
}

// ---- Axes ------------------------------------------------------------------

// Returns the ordinates of ticks at round numbers.
std::vector<double> ComputeTicks(const VerticalAxis& axis) {
  const double low = axis.ToMetric(axis.low), high = axis.ToMetric(axis.high);
  if (!axis.is_logarithmic) return MakeTicks(low, high);
  std::vector<double> ticks;
  if (high / low < 5) {
    for (const double tick : MakeTicks(low, high))
      ticks.push_back(std::log(tick));
    return ticks;
  }
  for (double ten = std::pow(10, std::floor(std::log10(low))); ten <= high;
       ten *= 10)
    for (const double digit : {1.0, 3.0})
      if (const double tick = digit * ten;
          tick >= low && tick <= high && (digit == 1 || high / low < 300))
        ticks.push_back(std::log(tick));
  return ticks;
}

std::string FormatSvg(double x, double y, const char* anchor,
                      const std::string& text) {
  return fmt::format(
      "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>", x, y,
      anchor, EscapeHtml(text));
}

std::string MakeAxesSvg(const VerticalAxis& axis,
                        const std::vector<std::string>& serials) {
  std::string svg = fmt::format("<path class=\"axis\" d=\"M{0} {1}V{2}H{3}\"/>",
                                kLeft, kTop, kBottom, kRight);
  for (const double tick : ComputeTicks(axis)) {
    svg += fmt::format("<path class=\"tick\" d=\"M{} {:.1f}H{}\"/>", kLeft,
                       axis.At(tick), kRight);
    svg += FormatSvg(kLeft - 6, axis.At(tick) + 4, "end",
                     FormatChartValue(axis.ToMetric(tick)));
  }
  size_t longest = 4;
  for (const std::string& serial : serials)
    longest = std::max(longest, serial.size());
  const auto most = static_cast<size_t>(
      (kRight - kLeft) / (7.0 * static_cast<double>(longest) + 24));
  const size_t step = (serials.size() + most - 1) / std::max<size_t>(most, 1);
  for (size_t u = 0; u < serials.size(); u += std::max<size_t>(step, 1))
    svg += FormatSvg(ComputeX(static_cast<double>(u), serials.size()),
                     kBottom + 30, "middle", serials[u]);
  return svg;
}

// ---- Lines -----------------------------------------------------------------

// Returns the centre line plus an offset: piecewise linear between jumps.
std::string MakeLineSvg(const DrawnChart& chart, const std::vector<int>& jumps,
                        double offset, const char* kind) {
  const size_t count = chart.values.size();
  std::string path;
  int begin = 0;
  for (size_t k = 0; k <= jumps.size(); ++k) {
    const int end = k < jumps.size() ? jumps[k] : static_cast<int>(count);
    path += fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}",
                        ComputeX(begin - 0.5, count),
                        chart.axis.At(chart.center_line[begin] + offset),
                        ComputeX(end - 0.5, count),
                        chart.axis.At(chart.center_line[end - 1] + offset));
    begin = end;
  }
  return fmt::format("<path class=\"{}\" d=\"{}\"/>", kind, path);
}

// Draws labels at the right ends of the lines, without overlap.
std::string MakeLineLabelsSvg(const DrawnChart& chart) {
  std::vector<double> offsets;
  if (std::isfinite(chart.upper)) offsets.push_back(chart.upper);
  if (chart.has_middle) offsets.push_back(0);
  if (std::isfinite(chart.lower)) offsets.push_back(chart.lower);
  std::string svg;
  double above = -100;
  for (const double offset : offsets) {
    const double ordinate = chart.center_line.back() + offset;
    const double y = std::max(chart.axis.At(ordinate) + 4, above + 12);
    svg += FormatSvg(kRight + 6, y, "start",
                     FormatChartValue(chart.axis.ToMetric(ordinate)));
    above = y;
  }
  return svg;
}

// ---- Units -----------------------------------------------------------------

// Returns a single path of bounded size, since coincident points are omitted.
std::string MakePointsSvg(const DrawnChart& chart,
                          const std::vector<bool>& is_out_of_limits) {
  std::set<std::pair<int, int>> places;
  for (size_t u = 0; u < chart.values.size(); ++u)
    if (!is_out_of_limits[u] && std::isfinite(chart.values[u]))
      places.emplace(std::lround(2 * ComputeX(static_cast<double>(u),
                                              is_out_of_limits.size())),
                     std::lround(2 * chart.axis.At(chart.values[u])));
  std::string path;
  for (const auto& [x, y] : places)
    path += fmt::format("M{:g} {:g}h0", x / 2.0, y / 2.0);
  return "<path class=\"units\" d=\"" + path + "\"/>";
}

std::string MakeOutOfLimitsSvg(const DrawnChart& chart,
                               const std::vector<bool>& is_out_of_limits,
                               const std::vector<std::string>& serials) {
  std::string svg;
  double free_from = -1;
  for (size_t u = 0; u < is_out_of_limits.size(); ++u) {
    if (!is_out_of_limits[u]) continue;
    const double x = ComputeX(static_cast<double>(u), is_out_of_limits.size()),
                 y = chart.axis.At(chart.values[u]);
    svg += fmt::format(
        "<path class=\"beyond\" d=\"M{:.1f} {:.1f}l5 9h-10z\"><title>{}: "
        "{}</title></path>",
        x, y - 6, serials[u],
        FormatChartValue(chart.axis.ToMetric(chart.values[u])));
    const double half = 3.6 * static_cast<double>(serials[u].size());
    if (x - half < free_from) continue;
    const bool is_left = x + 10 + 2 * half < kRight;
    svg += FormatSvg(is_left ? x + 8 : x - 8, y + 4, is_left ? "start" : "end",
                     serials[u]);
    free_from = x + 3 * half;
  }
  return svg;
}

std::string MakeJumpsSvg(const std::vector<int>& jumps, size_t count) {
  std::string path;
  for (const int jump : jumps)
    path += fmt::format("M{:.1f} {}V{}", ComputeX(jump - 0.5, count), kTop,
                        kBottom);
  return path.empty() ? "" : "<path class=\"jump\" d=\"" + path + "\"/>";
}

std::string MakeBatchesSvg(const ChartAnnotations& surroundings) {
  const std::vector<int>& batches = surroundings.batches;
  std::string svg;
  for (size_t begin = 0; begin < batches.size();) {
    size_t end = begin;
    while (end < batches.size() && batches[end] == batches[begin]) ++end;
    const double x = ComputeX(static_cast<double>(begin) - 0.5, batches.size());
    if (batches[begin] >= 0)
      svg += fmt::format(
          "<rect x=\"{:.1f}\" y=\"{}\" width=\"{:.1f}\" height=\"8\" "
          "fill=\"{}\"><title>{}</title></rect>",
          x, kBottom + 5,
          ComputeX(static_cast<double>(end) - 0.5, batches.size()) - x,
          GetBatchColor(batches[begin]),
          EscapeHtml(surroundings.batch_names[batches[begin]]));
    begin = end;
  }
  return svg;
}

}  // namespace

std::string MakeControlChartSvg(const ControlChart& chart,
                                const ChartAnnotations& surroundings) {
  const DrawnChart drawn = MakeDrawnChart(chart);
  std::vector<bool> is_out_of_limits;
  for (size_t u = 0; u < chart.values.size(); ++u) {
    const double offset = chart.values[u] - chart.center_line[u];
    is_out_of_limits.push_back(offset < chart.lower || offset > chart.upper);
  }
  std::string svg = fmt::format(
      "<svg class=\"control\" viewBox=\"0 0 {} {}\" role=\"img\" "
      "aria-label=\"control chart of {}\">",
      kWidth, kHeight, chart.name);
  svg += MakeAxesSvg(drawn.axis, surroundings.serials);
  svg += MakeJumpsSvg(surroundings.jumps, drawn.values.size());
  if (drawn.has_middle)
    svg += MakeLineSvg(drawn, surroundings.jumps, 0, "middle");
  for (const double limit : {drawn.lower, drawn.upper})
    if (std::isfinite(limit))
      svg += MakeLineSvg(drawn, surroundings.jumps, limit, "limit");
  svg += MakePointsSvg(drawn, is_out_of_limits);
  svg += MakeOutOfLimitsSvg(drawn, is_out_of_limits, surroundings.serials);
  svg += MakeLineLabelsSvg(drawn);
  return svg + MakeBatchesSvg(surroundings) + "</svg>\n";
}

const char* GetBatchColor(int batch) {
  constexpr const char* kColors[] = {"#e69f00", "#56b4e9", "#009e73",
                                     "#f0e442", "#0072b2", "#d55e00",
                                     "#cc79a7", "#999999"};
  return kColors[batch % 8];
}

std::string FormatChartValue(double value) {
  return std::abs(value) >= 1 ? fmt::format("{:.6g}", value)
                              : fmt::format("{:.4g}", value);
}

}  // namespace raygrid
