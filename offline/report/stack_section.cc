#include "report/stack_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "evaluation/stack_change.h"
#include "report/html.h"

namespace raygrid {
namespace {

// A line of a chart: one value for each of the changes.
struct StackLine {
  std::string name;
  const char* color;  // Okabe and Ito
  std::vector<double> values;
};

// A chart as SVG that shows without a script, over the changes' values.
std::string LineChart(const std::string& title,
                      const std::vector<StackChange>& changes,
                      const std::vector<StackLine>& lines) {
  constexpr double kWidth = 340, kHeight = 190, kLeft = 58, kRight = 12,
                   kTop = 14, kBottom = 34;
  double low = INFINITY, high = -INFINITY;
  for (const StackLine& line : lines)
    for (const double value : line.values) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  const double room = std::max(0.08 * (high - low), 1e-6);
  low -= room;
  high += room;
  const double first = changes.front().value, last = changes.back().value;
  const auto x_of = [&](double value) {
    return kLeft + (kWidth - kLeft - kRight) * (value - first) / (last - first);
  };
  const auto y_of = [&](double value) {
    return kTop + (kHeight - kTop - kBottom) * (high - value) / (high - low);
  };
  std::string svg = fmt::format(
      "<figure><figcaption>{}</figcaption><svg viewBox=\"0 0 {} {}\" "
      "width=\"{}\" font-family=\"sans-serif\" font-size=\"11\">",
      title, kWidth, kHeight, kWidth);
  for (int k = 0; k <= 4; ++k) {
    const double y = low + (high - low) * k / 4,
                 x = first + (last - first) * k / 4;
    svg += fmt::format(
        "<path d=\"M{} {:.1f}H{}\" stroke=\"#ddd\"/><text x=\"{}\" "
        "y=\"{:.1f}\" "
        "text-anchor=\"end\">{:.3g}</text><text x=\"{:.1f}\" y=\"{}\" "
        "text-anchor=\"middle\">{:.4g}</text>",
        kLeft, y_of(y), kWidth - kRight, kLeft - 6, y_of(y) + 4, y, x_of(x),
        kHeight - kBottom + 16, x);
  }
  for (size_t k = 0; k < lines.size(); ++k) {
    std::string path;
    for (size_t i = 0; i < changes.size(); ++i)
      path += fmt::format("{}{:.1f} {:.1f}", i == 0 ? "M" : "L",
                          x_of(changes[i].value), y_of(lines[k].values[i]));
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
std::vector<double> ValuesOf(const std::vector<StackChange>& changes,
                             const Figure& figure) {
  std::vector<double> values;
  for (const StackChange& change : changes) values.push_back(figure(change));
  return values;
}

std::string TableOf(const StackOfCameras& stack, const std::string& unit) {
  const int count = static_cast<int>(stack.deviations.size());
  if (count < 2) return "";
  std::vector<HtmlRow> rows;
  for (const StackChange& change : MeasureStackChanges(stack.cameras, count)) {
    const DeviationLattice& known = stack.deviations[rows.size()].lattice;
    rows.push_back({fmt::format("{:.4g}", change.value),
                    fmt::format("{:.2f}", change.focal_px),
                    fmt::format("{:+.3f} %", 100 * change.growth),
                    fmt::format("{:.2f}, {:.2f}", change.center_px.x(),
                                change.center_px.y()),
                    fmt::format("{:.3f}", change.distortion_px),
                    fmt::format("{:.4f}", known.MedianPx())});
  }
  return HtmlTable(
      {unit, "focal length px", "growth of the image", "centre px, x and y",
       "distortion px (RMS)", "standard deviation px (median)"},
      rows);
}

}  // namespace

std::string StackSection(const StackOfCameras& stack) {
  constexpr int kNumValues = 13;  // odd: the middle is one of them
  const CameraStack& cameras = stack.cameras;
  const std::vector<StackChange> changes =
      MeasureStackChanges(cameras, kNumValues);
  const std::string unit =
      (cameras.condition() == CameraCondition::kLensPosition
           ? "lens position, "
           : "temperature, ") +
      ConditionUnit(cameras.condition());
  const auto chart = [&](const std::string& what,
                         const std::vector<StackLine>& lines) {
    return LineChart(what + " over " + unit, changes, lines);
  };
  std::string html = fmt::format(
      "<h2>Over the range</h2>\n<p>The camera is known from {:g} to {:g} {}. "
      "Each control point is a polynomial of order {}. Growth and distortion "
      "are those of a far scene's image, against the middle of the range; "
      "distortion is what growth and a shift leave. The centre is that of the "
      "nearest lens with radial distortion; bumps of a lens move it, too. "
      "Figures above are of the middle, and held-out errors of features "
      "brought there.</p>\n",
      cameras.low(), cameras.high(), ConditionUnit(cameras.condition()),
      cameras.order());
  html += chart("Focal length in px",
                {{"", "#0072b2", ValuesOf(changes, [](const StackChange& c) {
                    return c.focal_px;
                  })}});
  const Eigen::Vector2d middle = changes[kNumValues / 2].center_px;
  html += chart("Centre, moved by px",
                {{"x", "#d55e00",
                  ValuesOf(changes,
                           [&](const StackChange& c) {
                             return c.center_px.x() - middle.x();
                           })},
                 {"y", "#009e73", ValuesOf(changes, [&](const StackChange& c) {
                    return c.center_px.y() - middle.y();
                  })}});
  html += chart("Distortion in px (RMS)",
                {{"", "#cc79a7", ValuesOf(changes, [](const StackChange& c) {
                    return c.distortion_px;
                  })}});
  return html + TableOf(stack, unit);
}

}  // namespace raygrid
