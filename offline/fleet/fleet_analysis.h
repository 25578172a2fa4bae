#ifndef RAYGRID_FLEET_FLEET_ANALYSIS_H
#define RAYGRID_FLEET_FLEET_ANALYSIS_H

#include <string>
#include <vector>

#include "fleet/fleet_statistics.h"
#include "fleet/fleet_table.h"
#include "fleet/gauge_study.h"
#include "fleet/lens_batches.h"

namespace raygrid {

/// The units of a fleet, and the statistics over them.
struct FleetAnalysis {
  std::vector<UnitRow> rows;     ///< all units, with their outlying metrics
  std::vector<size_t> compared;  ///< rows of the compared units, in their order
  FleetStatistics statistics;
  BatchComparison batches;
  GaugeStudy gauge;
};

/// Compares the units of a table with each other, without repeats of golden
/// units. folders: result folder of each row's unit.
FleetAnalysis AnalyseFleet(const std::vector<UnitRow>& rows,
                           const std::vector<std::string>& folders,
                           const MetricLimits& limits);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_ANALYSIS_H
