#ifndef RAYGRID_EXPERIMENTS_CHART_H
#define RAYGRID_EXPERIMENTS_CHART_H

#include <string>
#include <vector>

namespace raygrid {

struct ChartPoint {
  double x = 0, y = 0;
};

struct ChartSeries {
  std::string name;
  std::vector<ChartPoint> points;
  bool has_line = true;  ///< whether consecutive points are connected
};

struct ChartTick {
  double x = 0;
  std::string label;
};

/// A chart of up to six series over labelled positions on the x axis. Axis
/// labels include units.
struct Chart {
  std::string title, note;  ///< note below the title
  std::string x_label, y_label;
  std::vector<ChartTick> ticks;
  bool is_logarithmic = false;  ///< y axis; otherwise it starts at 0
  std::vector<ChartSeries> series;
};

/// Draws the chart as SVG, dark text on white. Series differ in colours that
/// are distinguishable with colour blindness (Okabe and Ito), and in markers.
std::string MakeChartSvg(const Chart& chart);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_CHART_H
