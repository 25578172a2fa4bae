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
  bool has_line = true;  ///< between its points
};

struct ChartTick {
  double x = 0;
  std::string label;
};

/// Up to six series over labelled places on the x axis. Units stand in the
/// axes' labels.
struct Chart {
  std::string title, note;  ///< the note stands below the title
  std::string x_label, y_label;
  std::vector<ChartTick> ticks;
  bool is_logarithmic = false;  ///< the y axis; else it starts at 0
  std::vector<ChartSeries> series;
};

/// A picture for any browser, dark text on white. Series differ in colours that
/// the colour-blind tell apart (Okabe and Ito), and in their markers.
std::string ChartSvg(const Chart& chart);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_CHART_H
