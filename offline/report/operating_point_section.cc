#include "report/operating_point_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "dataset/fixed_operating_point.h"
#include "evaluation/operating_point_change.h"
#include "evaluation/residual_statistics.h"
#include "report/axis_ticks.h"
#include "report/html.h"
#include "report/plots.h"

namespace raygrid {
namespace {

std::string DescribeRange(OperatingParameter condition) {
  return condition == OperatingParameter::kLensPosition ? "lens position"
                                                        : "temperature";
}

// A line of a chart, with one value per operating point.
struct FormatOperatingPointLine {
  std::string name;
  const char* color;  // from the Okabe-Ito palette
  std::vector<double> values;
};

// Returns a static SVG chart over the operating points.
std::string LineChart(const std::string& title,
                      const std::vector<OperatingPointChange>& changes,
                      const std::vector<FormatOperatingPointLine>& lines) {
  constexpr double kWidth = 340, kHeight = 190, kLeft = 58, kRight = 12,
                   kTop = 14, kBottom = 34;
  double low = INFINITY, high = -INFINITY;
  for (const FormatOperatingPointLine& line : lines)
    for (const double value : line.values) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  const double room = std::max(0.08 * (high - low), 1e-6);
  low -= room;
  high += room;
  const double first = changes.front().value, last = changes.back().value;
  const auto get_x = [&](double value) {
    return kLeft + (kWidth - kLeft - kRight) * (value - first) / (last - first);
  };
  const auto get_y = [&](double value) {
    return kTop + (kHeight - kTop - kBottom) * (high - value) / (high - low);
  };
  std::string svg = fmt::format(
      "<figure><figcaption>{}</figcaption><svg viewBox=\"0 0 {} {}\" "
      "width=\"{}\" style=\"max-width:100%\" font-family=\"sans-serif\" "
      "font-size=\"11\">",
      title, kWidth, kHeight, kWidth);
  for (const double y : MakeTicks(low, high))
    svg += fmt::format(
        "<path d=\"M{} {:.1f}H{}\" stroke=\"#ddd\"/><text x=\"{}\" "
        "y=\"{:.1f}\" text-anchor=\"end\">{:.6g}</text>",
        kLeft, get_y(y), kWidth - kRight, kLeft - 6, get_y(y) + 4, y);
  for (const double x : MakeTicks(first, last))
    svg += fmt::format(
        "<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{:.4g}</text>",
        get_x(x), kHeight - kBottom + 16, x);
  for (size_t k = 0; k < lines.size(); ++k) {
    std::string path;
    for (size_t i = 0; i < changes.size(); ++i)
      path += fmt::format("{}{:.1f} {:.1f}", i == 0 ? "M" : "L",
                          get_x(changes[i].value), get_y(lines[k].values[i]));
    svg += fmt::format(
        "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>", path,
        lines[k].color);
    if (lines.size() > 1)
      svg += fmt::format("<text x=\"{}\" y=\"{}\" fill=\"{}\">{}</text>",
                         kLeft + 8 + 90.0 * static_cast<double>(k), kHeight - 4,
                         lines[k].color, lines[k].name);
  }
  return svg + "</svg></figure>\n";
}

template <typename Figure>
std::vector<double> GetOperatingPoint(
    const std::vector<OperatingPointChange>& changes, const Figure& metric) {
  std::vector<double> values;
  for (const OperatingPointChange& change : changes)
    values.push_back(metric(change));
  return values;
}

std::string MakeUncertaintyTable(const OperatingPointCalibration& stack,
                                 const std::string& unit) {
  const int count = static_cast<int>(stack.deviations.size());
  if (count < 2) return "";
  std::vector<HtmlRow> rows;
  for (const OperatingPointChange& change :
       MeasureOperatingPointChanges(stack.cameras, count)) {
    const UncertaintyLattice& known = stack.deviations[rows.size()].lattice;
    rows.push_back({fmt::format("{:.4g}", change.value),
                    fmt::format("{:.2f}", change.focal_px),
                    fmt::format("{:+.3f} %", 100 * change.growth),
                    fmt::format("{:.2f}, {:.2f}", change.center_px.x(),
                                change.center_px.y()),
                    fmt::format("{:.3f}", change.distortion_px),
                    fmt::format("{:.4f}", known.MedianPx())});
  }
  return MakeHtmlTable(
      {unit, "focal length px", "image scale", "centre px, x and y",
       "distortion px (RMS)", "standard deviation px (median)"},
      rows);
}

// ---- Maps ------------------------------------------------------------------

// Returns a round number above nearly all values; values in single corners may
// exceed it.
double FullScale(std::vector<double> values) {
  constexpr double kPart = 0.98;
  values.erase(std::remove_if(values.begin(), values.end(),
                              [](double value) { return std::isnan(value); }),
               values.end());
  return values.empty() ? 1 : RoundUp(std::max(Quantile(values, kPart), 1e-6));
}

ColorBar MakeBar(const std::string& label, double full_scale_px) {
  return {ColorScale::kEven, label, "0",
          fmt::format("{:g} px +", full_scale_px)};
}

// Returns the change of distortion by position at both ends of the range,
// relative to the centre of the range, and its uncertainty.
std::string MakeUncertaintyMaps(const OperatingPointCalibration& stack) {
  constexpr int kColumns = 64, kRows = 48, kCellPx = 1;
  const OperatingPointModel& cameras = stack.cameras;
  const OperatingRange& range = cameras.ranges()[0];
  const std::string unit = OperatingParameterUnit(range.condition);
  const CentralGeneric center = cameras.At(cameras.Center());
  const Area& area = center.area();
  const std::vector<Eigen::Vector2d> places =
      SampleCellCenters(area, kColumns, kRows);
  struct End {
    std::string value;
    std::vector<Eigen::Vector2d> moves;
    std::vector<double> stddevs_px;
  };
  std::vector<End> ends;
  std::vector<double> sizes_px, stddevs_px;
  for (const double value : {range.low, range.high}) {
    End end = {fmt::format("{:g} {}", value, unit),
               MeasureDistortion(center, cameras.At({value}), places),
               {}};
    for (const Eigen::Vector2d& move : end.moves)
      sizes_px.push_back(move.norm());
    for (const OperatingPointUncertainty& known : stack.deviations)
      if (known.values[0] == value)
        for (const Eigen::Vector2d& place : places)
          end.stddevs_px.push_back(known.lattice.At(area, place));
    stddevs_px.insert(stddevs_px.end(), end.stddevs_px.begin(),
                      end.stddevs_px.end());
    ends.push_back(std::move(end));
  }
  const double size_px = FullScale(sizes_px), stddev_px = FullScale(stddevs_px);
  std::string html;
  for (const End& end : ends) {
    html += "<div class=\"pictures\">\n";
    html += EmbedHtmlImage(
        DrawDisplacementPlot(end.moves, kColumns, size_px),
        fmt::format("Distortion at {} against {:g}", end.value, range.Center()),
        AreaAxes(area),
        MakeHtmlColorBar(
            MakeBar("displacement; arrows are magnified", size_px)),
        "area");
    if (!end.stddevs_px.empty())
      html += EmbedHtmlImage(
          HeatMap(end.stddevs_px, kColumns, 0, stddev_px, kCellPx),
          "Predicted uncertainty at " + end.value, AreaAxes(area),
          MakeHtmlColorBar(MakeBar("standard deviation per axis", stddev_px)),
          "area");
    html += "</div>\n";
  }
  return html;
}

// Charts, table and maps of an operating-point model with one condition.
std::string FormatChanges(const OperatingPointCalibration& stack) {
  constexpr int kNumValues = 13;  // odd, to include the centre of the range
  const std::vector<OperatingPointChange> changes =
      MeasureOperatingPointChanges(stack.cameras, kNumValues);
  const OperatingParameter condition = stack.cameras.ranges()[0].condition;
  const std::string unit =
      DescribeRange(condition) + ", " + OperatingParameterUnit(condition);
  const auto chart = [&](const std::string& what,
                         const std::vector<FormatOperatingPointLine>& lines) {
    return LineChart(what + " over " + unit, changes, lines);
  };
  std::string html = "<div class=\"pictures\">\n";
  html += chart("Focal length in px",
                {{"", "#0072b2",
                  GetOperatingPoint(changes, [](const OperatingPointChange& c) {
                    return c.focal_px;
                  })}});
  const Eigen::Vector2d center = changes[kNumValues / 2].center_px;
  html +=
      chart("Shift of the principal point in px",
            {{"x", "#d55e00",
              GetOperatingPoint(changes,
                                [&](const OperatingPointChange& c) {
                                  return c.center_px.x() - center.x();
                                })},
             {"y", "#009e73",
              GetOperatingPoint(changes, [&](const OperatingPointChange& c) {
                return c.center_px.y() - center.y();
              })}});
  html += chart("Distortion in px (RMS)",
                {{"", "#cc79a7",
                  GetOperatingPoint(changes, [](const OperatingPointChange& c) {
                    return c.distortion_px;
                  })}});
  html += "</div>\n";
  return html + MakeUncertaintyTable(stack, unit) + MakeUncertaintyMaps(stack);
}

}  // namespace

std::string MakeOperatingPointSection(const OperatingPointCalibration& stack) {
  const OperatingPointModel& cameras = stack.cameras;
  const std::vector<OperatingRange>& ranges = cameras.ranges();
  std::string known, orders;
  for (size_t r = 0; r < ranges.size(); ++r) {
    known += (r > 0 ? ", and from " : "from ") + ranges[r].Text();
    orders += fmt::format("{}a polynomial of order {}{}", r > 0 ? " and " : "",
                          cameras.orders()[r],
                          ranges.size() > 1
                              ? " of the " + DescribeRange(ranges[r].condition)
                              : "");
  }
  std::string html = fmt::format(
      "<h2>Operating range</h2>\n<p>The camera is calibrated {}. Each control "
      "point is {}{}. Image scale and distortion are for a distant scene, "
      "relative to the centre of the range; distortion is the change that "
      "remains after scale and shift. The principal point is that of the "
      "nearest radial model. All sections above are for the centre of the "
      "range, with held-out features mapped there.</p>\n",
      known, ranges.size() > 1 ? "the sum of " : "", orders);
  if (ranges.size() == 1) return html + FormatChanges(stack);
  for (size_t r = 0; r < ranges.size(); ++r) {
    const OperatingRange& other = ranges[1 - r];
    html += fmt::format("<h3>Over the {}, at {:g} {}</h3>\n",
                        DescribeRange(ranges[r].condition), other.Center(),
                        OperatingParameterUnit(other.condition)) +
            FormatChanges(SliceOperatingPointModel(stack, r));
  }
  return html;
}

}  // namespace raygrid
