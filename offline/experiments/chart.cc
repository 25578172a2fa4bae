#include "experiments/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "report/html.h"

namespace raygrid {
namespace {

constexpr double kWidth = 720, kHeight = 460;
constexpr double kMargin = 14;
constexpr double kLeft = 80, kRight = 690, kTop = 106, kBottom = 395;

// The Okabe-Ito palette: blue, vermilion, green, purple, orange and sky blue.
const char* const kColours[] = {"#0072b2", "#d55e00", "#009e73",
                                "#cc79a7", "#e69f00", "#56b4e9"};
constexpr int kNumStyles = 6;

std::string Text(double x, double y, const std::string& attributes,
                 const std::string& text) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\"{}>{}</text>\n", x, y,
                     attributes, EscapeHtml(text));
}

std::string Line(double x0, double y0, double x1, double y1,
                 const char* colour) {
  return fmt::format(
      "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" "
      "stroke=\"{}\"/>\n",
      x0, y0, x1, y1, colour);
}

// Rounds up to 1, 2 or 5 times a power of ten.
double RoundStep(double at_least) {
  const double power = std::pow(10, std::floor(std::log10(at_least)));
  for (const double factor : {1, 2, 5})
    if (factor * power >= at_least * (1 - 1e-9)) return factor * power;
  return 10 * power;
}

// The axes of a chart, which map values to picture coordinates.
class Axes {
 public:
  explicit Axes(const Chart& chart) : is_logarithmic_(chart.is_logarithmic) {
    for (const ChartTick& tick : chart.ticks) IncludeX(tick.x);
    double lowest = INFINITY, highest = 0;
    for (const ChartSeries& series : chart.series) {
      for (const ChartPoint& point : series.points) {
        IncludeX(point.x);
        highest = std::max(highest, point.y);
        if (point.y > 0) lowest = std::min(lowest, point.y);
      }
    }
    if (!(highest > 0)) lowest = highest = 1;
    const double margin = 0.05 * std::max(x1_ - x0_, 1.0);
    x0_ -= margin;
    x1_ += margin;
    is_logarithmic_ ? ChooseDecades(lowest, highest) : ChooseSteps(highest);
  }

  double X(double x) const {
    return kLeft + (x - x0_) / (x1_ - x0_) * (kRight - kLeft);
  }
  double Y(double y) const {
    return kBottom - (Scaled(y) - Scaled(ticks_.front())) /
                         (Scaled(ticks_.back()) - Scaled(ticks_.front())) *
                         (kBottom - kTop);
  }
  bool ContainsPoint(const ChartPoint& point) const {
    return point.y > 0 || !is_logarithmic_;
  }
  const std::vector<double>& ticks() const { return ticks_; }

 private:
  void IncludeX(double x) {
    x0_ = std::min(x0_, x);
    x1_ = std::max(x1_, x);
  }
  double Scaled(double y) const { return is_logarithmic_ ? std::log10(y) : y; }

  void ChooseSteps(double highest) {
    const double step = RoundStep(highest / 6);
    for (int k = 0; k == 0 || ticks_.back() < highest; ++k)
      ticks_.push_back(k * step);
  }
  // Ticks at 1, 2, 5, 10 ... that enclose all values.
  void ChooseDecades(double lowest, double highest) {
    for (int power = static_cast<int>(std::floor(std::log10(lowest)));
         ticks_.empty() || ticks_.back() < highest; ++power)
      for (const double factor : {1, 2, 5})
        if (ticks_.empty() || ticks_.back() < highest)
          ticks_.push_back(factor * std::pow(10, power));
    while (ticks_.size() > 2 && ticks_[1] <= lowest)
      ticks_.erase(ticks_.begin());
  }

  bool is_logarithmic_;
  double x0_ = INFINITY, x1_ = -INFINITY;
  std::vector<double> ticks_;  // y axis, from bottom to top
};

std::string Marker(int style, double x, double y) {
  switch (style) {
    case 0:
      return fmt::format(
          "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4.5\" fill=\"{}\"/>\n", x, y,
          kColours[style]);
    case 1:
      return fmt::format(
          "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"8\" height=\"8\" "
          "fill=\"{}\"/>\n",
          x - 4, y - 4, kColours[style]);
    case 2:
      return fmt::format(
          "<path d=\"M{:.1f} {:.1f}l5.5 9h-11z\" fill=\"{}\"/>\n", x, y - 6,
          kColours[style]);
    case 3:
      return fmt::format(
          "<path d=\"M{:.1f} {:.1f}l5.5 5.5l-5.5 5.5l-5.5 -5.5z\" "
          "fill=\"{}\"/>\n",
          x, y - 5.5, kColours[style]);
    case 4:
      return fmt::format(
          "<path d=\"M{:.1f} {:.1f}l5.5 -9h-11z\" fill=\"{}\"/>\n", x, y + 6,
          kColours[style]);
    default:
      return fmt::format(
          "<path d=\"M{:.1f} {:.1f}l9 9m0 -9l-9 9\" stroke=\"{}\" "
          "stroke-width=\"2.5\"/>\n",
          x - 4.5, y - 4.5, kColours[style]);
  }
}

// Whether ticks are so dense that every second label is drawn lower.
bool AreTicksCrowded(const Chart& chart, const Axes& axes) {
  constexpr double kLetter = 7.5;
  for (size_t i = 1; i < chart.ticks.size(); ++i) {
    const ChartTick &a = chart.ticks[i - 1], &b = chart.ticks[i];
    const double width =
        kLetter * static_cast<double>(a.label.size() + b.label.size() + 1) / 2;
    if (width > axes.X(b.x) - axes.X(a.x)) return true;
  }
  return false;
}

std::string Frame(const Chart& chart, const Axes& axes) {
  std::string svg =
      Text(kMargin, 26, " font-size=\"17\" font-weight=\"bold\"", chart.title) +
      Text(kMargin, 46, " font-size=\"12\"", chart.note);
  for (const double y : axes.ticks()) {
    svg += Line(kLeft, axes.Y(y), kRight, axes.Y(y), "#dddddd");
    svg += Text(kLeft - 8, axes.Y(y) + 4, " text-anchor=\"end\"",
                fmt::format("{:.4g}", y));
  }
  const bool is_crowded = AreTicksCrowded(chart, axes);
  for (size_t i = 0; i < chart.ticks.size(); ++i) {
    const double x = axes.X(chart.ticks[i].x);
    svg += Line(x, kBottom, x, kBottom + 5, "black");
    svg += Text(x, kBottom + (is_crowded && i % 2 == 1 ? 35 : 20),
                " text-anchor=\"middle\"", chart.ticks[i].label);
  }
  svg += Line(kLeft, kBottom, kRight, kBottom, "black");
  svg += Line(kLeft, kTop, kLeft, kBottom, "black");
  svg += Text((kLeft + kRight) / 2, kBottom + 54, " text-anchor=\"middle\"",
              chart.x_label);
  const double center = (kTop + kBottom) / 2;
  svg += Text(20, center,
              fmt::format(" text-anchor=\"middle\" transform=\"rotate(-90 20 "
                          "{:.1f})\"",
                          center),
              chart.y_label);
  return svg;
}

std::string Legend(const Chart& chart) {
  constexpr double kLetter = 7, kLineHeight = 18;
  std::string svg;
  double x = kMargin + 6, y = 66;
  for (size_t i = 0; i < chart.series.size(); ++i) {
    const double width =
        12 + kLetter * static_cast<double>(chart.series[i].name.size());
    if (i > 0 && x + width > kWidth) {
      x = kMargin + 6;
      y += kLineHeight;
    }
    svg += Marker(static_cast<int>(i) % kNumStyles, x, y);
    svg += Text(x + 12, y + 4, "", chart.series[i].name);
    x += width + 32;
  }
  return svg;
}

std::string Series(const ChartSeries& series, int style, const Axes& axes) {
  std::string path, markers;
  bool goes_on = false;  // after a visible point
  for (const ChartPoint& point : series.points) {
    const bool went_on = std::exchange(goes_on, axes.ContainsPoint(point));
    if (!goes_on) continue;
    const double x = axes.X(point.x), y = axes.Y(point.y);
    path += fmt::format("{}{:.1f} {:.1f}", went_on ? "L" : "M", x, y);
    markers += Marker(style, x, y);
  }
  if (!series.has_line || path.empty()) return markers;
  return fmt::format(
             "<path d=\"{}\" fill=\"none\" stroke=\"{}\" "
             "stroke-width=\"2\"/>\n",
             path, kColours[style]) +
         markers;
}

}  // namespace

std::string MakeChartSvg(const Chart& chart) {
  const Axes axes(chart);
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\" font-size=\"13\" "
      "role=\"img\" aria-label=\"{2}\">\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
      kWidth, kHeight, EscapeHtml(chart.title));
  svg += Frame(chart, axes);
  for (size_t i = 0; i < chart.series.size(); ++i)
    svg += Series(chart.series[i], static_cast<int>(i) % kNumStyles, axes);
  return svg + Legend(chart) + "</svg>\n";
}

}  // namespace raygrid
