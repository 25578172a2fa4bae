#ifndef RAYGRID_FLEET_FLEET_STATISTICS_H
#define RAYGRID_FLEET_FLEET_STATISTICS_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fleet/mean_changes.h"

namespace raygrid {

/// A metric of each unit, in the order of units; NaN if unknown.
struct FleetMetric {
  std::string name;
  std::vector<double> values;
  bool is_positive = false;  ///< whether its logarithm is normal

  /// Returns the values, or their logarithms if these are normally distributed;
  /// NaN for logarithms of values that are not positive.
  std::vector<double> TransformedValues() const;
};

/// The units in chronological order.
struct FleetInput {
  /// One row per unit: its pixels for the common directions.
  Eigen::MatrixXd pixels;
  std::vector<FleetMetric> metrics;
};

/// The values of all units, and control limits that a fleet without outliers
/// exceeds with the false-alarm probability of FindOutliers().
struct ControlChart {
  std::string name;
  std::vector<double> values;
  std::vector<double> center_line;  ///< mean of each unit, piecewise by jumps
  double lower = 0, upper = 0;      ///< relative to middle; infinite: no limit
  bool is_logarithm = false;        ///< values and middle are logarithms
};

struct OutlierUnit {
  int unit = 0;
  std::vector<std::string> charts;  ///< charts whose limits it exceeds
};

struct FleetStatistics {
  std::vector<ControlChart> charts;
  std::vector<MeanJump> jumps;        ///< by unit
  std::vector<MeanDrift> drifts;      ///< ordered as charts
  std::vector<OutlierUnit> outliers;  ///< by unit
  int num_directions = 0;             ///< principal directions of the lenses
};

/// The minimum number of units for control limits.
constexpr int kMinFleetUnits = 20;
/// The probability of any false alarm in a fleet without outliers, and that of
/// reporting any change of a constant mean.
constexpr double kFleetFalseAlarmProbability = 0.05;

/// Finds the outliers of a fleet. Changes of the mean are found first
/// (FindMeanChanges()). Two charts about the changing mean describe the lenses:
/// "lens" is Hotelling's T^2 over the principal directions of variation,
/// "shape" the squared distance in pixels from the space of these directions,
/// in which inliers do not vary. Each metric has a chart of its own.
///
/// For a fleet without outliers, the probability of any alarm over all charts
/// and units is kFleetFalseAlarmProbability. For a fleet with a constant mean,
/// the probability of any reported jump or drift is the same.
///
/// With fewer than kMinFleetUnits units, there are no charts.
FleetStatistics FindOutliers(const FleetInput& input);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_STATISTICS_H
