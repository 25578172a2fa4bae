#ifndef RAYGRID_FLEET_LENS_BATCHES_H
#define RAYGRID_FLEET_LENS_BATCHES_H

#include <string>
#include <vector>

#include "fleet/fleet_statistics.h"

namespace raygrid {

/// A figure by batches of lenses, or "lens": the lenses themselves.
struct BatchedFigure {
  std::string name;
  bool differs = false;  ///< beyond what the chance of a comparison explains
  double chance = 1;     ///< of such differences between equal batches
  /// Of each batch, and the deviation of units within batches. Geometric for
  /// figures whose logarithm scatters evenly, with a deviation of that
  /// logarithm; "lens" has none.
  std::vector<double> means;
  double deviation_within = 0;
};

/// How batches differ.
struct BatchComparison {
  std::vector<std::string> batches;  ///< in the order of their bytes
  std::vector<int> num_units;        ///< compared, of each batch
  std::vector<BatchedFigure> figures;
};

/// The fewest units of a batch that is compared.
constexpr int kFewestBatchUnits = 3;

/// Compares batches by analysis of variance: each figure by its F, the lenses
/// along the directions in which they vary by Pillai's trace. Units that are
/// unusual and those without a batch are left out, and so are batches of fewer
/// than kFewestBatchUnits others. Equal batches differ in any figure with a
/// chance of kFleetChance.
///
/// batches: the name of each unit's, or "". Fewer than two batches have nothing
/// to compare: the result is empty.
BatchComparison CompareLensBatches(const FleetInput& input,
                                   const std::vector<std::string>& batches,
                                   const std::vector<UnusualUnit>& unusual);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_LENS_BATCHES_H
