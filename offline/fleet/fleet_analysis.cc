#include "fleet/fleet_analysis.h"

#include <set>

#include "fleet/fleet_input.h"

namespace raygrid {
namespace {

// Returns a gauge study of the repeat calibrations of golden units, including
// the unit itself if present.
GaugeStudy StudyRepeats(const std::vector<UnitRow>& rows,
                        const std::vector<std::string>& folders,
                        const FleetInput& fleet, const MetricLimits& limits) {
  std::set<std::string> goldens;
  for (const UnitRow& row : rows)
    if (!row.repeats.empty()) goldens.insert(row.repeats);
  std::vector<size_t> candidates;
  for (size_t k = 0; k < rows.size(); ++k)
    if (!rows[k].repeats.empty() || goldens.count(rows[k].serial) > 0)
      candidates.push_back(k);
  const ComparedUnits units = CompareUnits(rows, folders, candidates);
  std::vector<GaugeRepeat> repeats;
  for (const size_t k : units.rows)
    repeats.push_back(
        {rows[k].repeats.empty() ? rows[k].serial : rows[k].repeats,
         rows[k].person, rows[k].station});
  return StudyGauge(units.input, repeats, fleet, limits);
}

}  // namespace

FleetAnalysis AnalyseFleet(const std::vector<UnitRow>& rows,
                           const std::vector<std::string>& folders,
                           const MetricLimits& limits) {
  FleetAnalysis fleet;
  fleet.rows = rows;
  std::vector<size_t> candidates;
  for (size_t k = 0; k < rows.size(); ++k)
    if (rows[k].repeats.empty()) candidates.push_back(k);
  const ComparedUnits units = CompareUnits(rows, folders, candidates);
  fleet.compared = units.rows;
  fleet.statistics = FindOutliers(units.input);
  for (const OutlierUnit& outliers : fleet.statistics.outliers)
    fleet.rows[units.rows[outliers.unit]].outliers = outliers.charts;
  std::vector<std::string> batches;
  for (const size_t row : units.rows) batches.push_back(rows[row].lens_batch);
  fleet.batches =
      CompareLensBatches(units.input, batches, fleet.statistics.outliers);
  fleet.gauge = StudyRepeats(rows, folders, units.input, limits);
  return fleet;
}

}  // namespace raygrid
