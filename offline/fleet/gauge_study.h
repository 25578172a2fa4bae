#ifndef RAYGRID_FLEET_GAUGE_STUDY_H
#define RAYGRID_FLEET_GAUGE_STUDY_H

#include <optional>
#include <string>
#include <vector>

#include "fleet/batch_plan.h"
#include "fleet/fleet_statistics.h"

namespace raygrid {

/// A calibration of a golden unit, one of several.
struct GaugeRepeat {
  std::string golden;           ///< the unit's serial
  std::string person, station;  ///< "" where it is not told
};

/// The part of operators, or of stations, in the spread.
struct GaugeFactor {
  std::string name;              ///< "operator" or "station"
  double deviation = 0;          ///< of their means; 0 if they explain nothing
  std::optional<double> chance;  ///< of such differences between equal ones
};

/// How well a figure is measured.
struct GaugeFigure {
  std::string name;  ///< of the figure; "pixels": the RMS over all directions
  bool is_logarithm = false;         ///< deviations are parts of the figure
  double repeatability = 0;          ///< deviation of repeats in one setting
  std::vector<GaugeFactor> factors;  ///< that can be told apart from others
  double gauge = 0;                  ///< deviation of repeats and factors
  /// The fleet's deviation of units, the gauge's part of it and the number of
  /// classes of units that can be told apart, sqrt(2) unit / gauge.
  std::optional<double> fleet, part_of_fleet, num_classes;
  /// The part of the plan's limits that six deviations of the gauge take.
  std::optional<double> part_of_limits;
};

struct GaugeStudy {
  int num_repeats = 0, num_goldens = 0;
  int freedoms = 0;  ///< of the repeatability
  std::vector<GaugeFigure> figures;
  /// Why there are no figures, or which factor cannot be told; empty if all is.
  std::vector<std::string> untold;
};

/// Gauge repeatability and reproducibility by analysis of variance. A value is
/// the sum of its golden unit's, its operator's, its station's and chance's
/// part. Repeats need not be balanced: variances are those by which reductions
/// of squares are as expected (Henderson 1953, method 3). What operators do to
/// one golden unit alone counts as chance.
///
/// input: the repeats, whose temperature is no measurement and is left out, and
/// so is a figure that some do not have, or all have alike. fleet: the units
/// that they are compared with, if there are kFewestFleetUnits. Each is in the
/// order of its units.
GaugeStudy StudyGauge(const FleetInput& input,
                      const std::vector<GaugeRepeat>& repeats,
                      const FleetInput& fleet, const FigureLimits& limits);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_GAUGE_STUDY_H
