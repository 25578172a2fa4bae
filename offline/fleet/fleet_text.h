/// Texts about metrics and changes, for fleet.html and the terminal.
#ifndef RAYGRID_FLEET_FLEET_TEXT_H
#define RAYGRID_FLEET_FLEET_TEXT_H

#include <string>
#include <vector>

#include "fleet/fleet_analysis.h"

namespace raygrid {

/// Returns the name of a metric in sentences: "the focal length".
std::string GetMetricTitle(const std::string& name);
/// Returns the unit of measurement, with a leading space; empty if
/// dimensionless.
std::string GetMetricUnit(const std::string& name);

/// Returns a clause for each chart in which a compared unit is an outlier, with
/// the value and the control limits.
std::vector<std::string> DescribeOutliers(const FleetStatistics& statistics,
                                          int unit);

/// Returns a sentence for each jump and drift of a mean, with the names of
/// units, and of the batch if a jump coincides with its first unit.
std::vector<std::string> DescribeChanges(const FleetAnalysis& fleet);

/// Returns a sentence for each metric that differs between batches.
std::vector<std::string> DescribeBatches(const BatchComparison& batches);

/// Returns a sentence on each gauge metric, followed by sentences on quantities
/// that are not observable.
std::vector<std::string> DescribeGauge(const GaugeStudy& gauge);

/// Returns a sentence on the units' calibration times; empty if unknown.
std::string DescribeDuration(const std::vector<UnitRow>& rows);

/// Formats "12.34 px", or "1.2 %" for a relative deviation.
std::string FormatGaugeStdDev(const GaugeMetric& metric, double deviation);

/// Formats "< 0.0001", or the value.
std::string FormatProbability(double p_value);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_TEXT_H
