#ifndef RAYGRID_FLEET_FLEET_STATISTICS_H
#define RAYGRID_FLEET_FLEET_STATISTICS_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fleet/mean_changes.h"

namespace raygrid {

/// A figure of each unit in their order; NaN where it is not known.
struct FleetFigure {
  std::string name;
  std::vector<double> values;
  bool is_positive = false;  ///< its logarithm is what scatters evenly

  /// The values, or their logarithms: NaN of what is not positive.
  std::vector<double> Scattering() const;
};

/// Units in their order, which is that of time.
struct FleetInput {
  /// A row for each unit: the pixels at which it sees some directions, all the
  /// same ones for all units.
  Eigen::MatrixXd pixels;
  std::vector<FleetFigure> figures;
};

/// A value of each unit, and the limits that one of a fleet without outliers
/// leaves with the chance that FindOutliers() states.
struct ControlChart {
  std::string name;
  std::vector<double> values;
  std::vector<double> middle;   ///< of the units before and behind each jump
  double lower = 0, upper = 0;  ///< from the middle; infinite: no limit
  bool is_logarithm = false;    ///< values and middle are those of a figure
};

struct UnusualUnit {
  int unit = 0;
  std::vector<std::string> charts;  ///< whose limits it leaves
};

struct FleetStatistics {
  std::vector<ControlChart> charts;
  std::vector<MeanJump> jumps;       ///< by unit
  std::vector<MeanDrift> drifts;     ///< in the order of charts
  std::vector<UnusualUnit> unusual;  ///< by unit
  int num_directions = 0;            ///< in which the fleet's lenses vary
};

/// The fewest units of which limits can be told.
constexpr int kFewestFleetUnits = 20;
/// The chance of any alarm in a fleet in which nothing is unusual, and that of
/// any change of a steady mean.
constexpr double kFleetChance = 0.05;

/// Finds what is unusual in a fleet. Changes of a mean come first
/// (FindMeanChanges()). About the changing means, there are two charts of the
/// lenses themselves: "lens" is Hotelling's T^2 over the principal directions
/// in which lenses vary, "shape" the squared distance in pixels from these
/// directions, which no usual lens has. Then a chart for each figure.
///
/// A fleet without outliers gives an alarm with a chance of kFleetChance, all
/// charts and units together, and a steady one a jump or a drift with another
/// kFleetChance.
///
/// Fewer than kFewestFleetUnits units have no charts.
FleetStatistics FindOutliers(const FleetInput& input);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_STATISTICS_H
