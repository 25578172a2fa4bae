#ifndef RAYGRID_FLEET_GAUGE_STUDY_H
#define RAYGRID_FLEET_GAUGE_STUDY_H

#include <optional>
#include <string>
#include <vector>

#include "fleet/batch_plan.h"
#include "fleet/fleet_statistics.h"

namespace raygrid {

/// One of several calibrations of a golden unit.
struct GaugeRepeat {
  std::string golden;           ///< serial of the unit
  std::string person, station;  ///< "" if unknown
};

/// The contribution of operators or stations to the variance.
struct GaugeFactor {
  std::string name;               ///< "operator" or "station"
  double deviation = 0;           ///< between their means; 0 if insignificant
  std::optional<double> p_value;  ///< p-value of equal means
};

/// The measurement uncertainty of a metric.
struct GaugeMetric {
  std::string name;           ///< metric; "pixels": RMS over all directions
  bool is_logarithm = false;  ///< deviations are relative
  double repeatability = 0;   ///< standard deviation under equal conditions
  std::vector<GaugeFactor> factors;  ///< separable factors
  double gauge = 0;                  ///< repeats and factors combined
  /// The standard deviation of units in the fleet, the gauge's fraction of it,
  /// and the number of distinct categories, sqrt(2) unit / gauge.
  std::optional<double> fleet, fraction_of_fleet, num_classes;
  /// Fraction of the plan's tolerance covered by six gauge standard deviations.
  std::optional<double> fraction_of_limits;
};

struct GaugeStudy {
  int num_repeats = 0, num_goldens = 0;
  int degrees_of_freedom = 0;  ///< degrees of freedom of the repeatability
  std::vector<GaugeMetric> metrics;
  /// Explains why there are no results, or which factor is not observable;
  /// otherwise empty.
  std::vector<std::string> unobservable_reason;
};

/// Gauge repeatability and reproducibility by analysis of variance. A value is
/// the sum of the effects of golden unit, operator and station, and noise.
/// Repeats need not be balanced: the variance components are estimated by
/// equating the reductions of the sum of squares with their expectations
/// (Henderson 1953, method 3). Interactions of operator and unit count as
/// noise.
///
/// input: the repeats. Metrics that are missing for some repeats or constant
/// are ignored, and so is the temperature, which is not a measurement. fleet:
/// the units for comparison, if there are at least kMinFleetUnits. Both are in
/// the order of their units.
GaugeStudy StudyGauge(const FleetInput& input,
                      const std::vector<GaugeRepeat>& repeats,
                      const FleetInput& fleet, const MetricLimits& limits);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_GAUGE_STUDY_H
