#ifndef RAYGRID_FLEET_CONTROL_CHART_PICTURE_H
#define RAYGRID_FLEET_CONTROL_CHART_PICTURE_H

#include <string>
#include <vector>

#include "fleet/fleet_statistics.h"

namespace raygrid {

/// The surroundings of a chart's values.
struct ChartSurroundings {
  std::vector<std::string> serials;  ///< of the units
  std::vector<int> jumps;            ///< units at which the mean jumps
  /// The batch of each unit's lens, counted from 0, or -1; empty: none is
  /// known.
  std::vector<int> batches;
  std::vector<std::string> batch_names;
};

/// A chart as SVG that shows without a script: a point for each unit, triangles
/// with serials beyond the limits, the middle, dashed limits with their
/// figures, dotted lines at jumps, and a strip of batches below. A chart
/// without a lower limit has a logarithmic axis, as that of logarithms has.
std::string ControlChartSvg(const ControlChart& chart,
                            const ChartSurroundings& surroundings);

/// The colour of a batch, again from the first one on after the last one.
const char* ColorOfBatch(int batch);

/// A figure as charts, tables and sentences have it: four to six digits.
std::string ChartFigure(double value);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_CONTROL_CHART_PICTURE_H
