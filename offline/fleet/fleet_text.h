/// Text about metrics and changes, for page and terminal.
#ifndef RAYGRID_FLEET_FLEET_TEXT_H
#define RAYGRID_FLEET_FLEET_TEXT_H

#include <string>
#include <vector>

#include "fleet/fleet_analysis.h"

namespace raygrid {

/// The name of a metric in sentences: "the focal length".
std::string GetMetricTitle(const std::string& name);
/// The unit of measurement, with a space; empty if it has none.
std::string GetMetricUnit(const std::string& name);

/// One clause for each chart in which a unit is an outlier: "the focal length
/// (focal_px) is 812.4, usual are 798.1 to 803.2 px". unit: a compared one.
std::vector<std::string> DescribeOutliers(const FleetStatistics& statistics,
                                          int unit);

/// One sentence for each jump and drift of a mean, with the names of units, and
/// of the batch if a jump coincides with its first unit.
std::vector<std::string> DescribeChanges(const FleetAnalysis& fleet);

/// One sentence for each metric that differs between batches.
std::vector<std::string> DescribeBatches(const BatchComparison& batches);

/// One sentence on each gauge metric, then on what is not determined.
std::vector<std::string> DescribeGauge(const GaugeStudy& gauge);

/// One sentence on the units' calibration times; empty if unknown.
std::string DescribeDuration(const std::vector<UnitRow>& rows);

/// "12.34 px", or "1.2 %" of a relative deviation.
std::string FormatGaugeDeviation(const GaugeMetric& metric, double deviation);

/// "< 0.0001", or the value.
std::string FormatProbability(double chance);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_TEXT_H
