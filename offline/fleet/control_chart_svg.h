#ifndef RAYGRID_FLEET_CONTROL_CHART_SVG_H
#define RAYGRID_FLEET_CONTROL_CHART_SVG_H

#include <string>
#include <vector>

#include "fleet/fleet_statistics.h"

namespace raygrid {

/// Annotations of a control chart: serial numbers, jumps of the mean, and lens
/// batches.
struct ChartAnnotations {
  std::vector<std::string> serials;  ///< serials of the units
  std::vector<int> jumps;            ///< units at which the mean jumps
  /// 0-based lens batch of each unit, or -1; empty if unknown.
  std::vector<int> batches;
  std::vector<std::string> batch_names;
};

/// Draws a chart as SVG, readable without a script: a point per unit, triangles
/// with serials for outliers, the centre line, dashed limits with their values,
/// dotted lines at jumps, and a strip of batches below. A chart without a lower
/// limit has a logarithmic axis, like a chart of logarithms.
std::string MakeControlChartSvg(const ControlChart& chart,
                                const ChartAnnotations& surroundings);

/// Returns the colour of a batch; colours repeat cyclically.
const char* GetBatchColor(int batch);

/// Formats a metric for charts, tables and sentences: four to six digits.
std::string FormatChartValue(double value);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_CONTROL_CHART_SVG_H
