#ifndef RAYGRID_FLEET_LENS_BATCHES_H
#define RAYGRID_FLEET_LENS_BATCHES_H

#include <string>
#include <vector>

#include "fleet/fleet_statistics.h"

namespace raygrid {

/// A metric compared between lens batches, or "lens": the principal directions.
struct BatchedMetric {
  std::string name;
  bool differs = false;  ///< significant at the level per comparison
  double p_value = 1;    ///< p-value of equal batches
  /// Mean of each batch, and the standard deviation within batches. For metrics
  /// with normally distributed logarithms: geometric mean, and the deviation of
  /// the logarithm. Empty for "lens".
  std::vector<double> means;
  double within_batch_stddev = 0;
};

/// The differences between batches.
struct BatchComparison {
  std::vector<std::string> batches;  ///< sorted bytewise
  std::vector<int> num_units;        ///< number of compared units in each batch
  std::vector<BatchedMetric> metrics;
};

/// The minimum number of units of a batch that is compared.
constexpr int kMinBatchUnits = 3;

/// Compares batches by analysis of variance: each metric by its F statistic,
/// lenses along their principal directions by Pillai's trace. Outliers, units
/// without a batch and batches of fewer than kMinBatchUnits other units are
/// omitted. For equal batches, the probability of any significant difference is
/// kFleetFalseAlarmProbability.
///
/// batches: name of each unit's batch, or "". The result is empty for fewer
/// than two batches.
BatchComparison CompareLensBatches(const FleetInput& input,
                                   const std::vector<std::string>& batches,
                                   const std::vector<OutlierUnit>& outliers);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_LENS_BATCHES_H
