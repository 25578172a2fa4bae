#ifndef RAYGRID_FLEET_FLEET_STATISTICS_H
#define RAYGRID_FLEET_FLEET_STATISTICS_H

#include <Eigen/Core>
#include <string>
#include <vector>

namespace raygrid {

/// A figure of each unit in their order; NaN where it is not known.
struct FleetFigure {
  std::string name;
  std::vector<double> values;
  bool is_positive = false;  ///< its logarithm is what scatters evenly
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
};

/// The mean of a figure changes from one unit to the next, or that of the
/// lenses along any of the directions in which they vary.
struct MeanJump {
  std::string name;              ///< of the figure, or "lens"
  int unit = 0;                  ///< the first one with the new mean
  double before = 0, after = 0;  ///< middle values of the figure; lenses: 0
  double sigmas = 0;             ///< the change over its standard deviation
};

struct UnusualUnit {
  int unit = 0;
  std::vector<std::string> charts;  ///< whose limits it leaves
};

struct FleetStatistics {
  std::vector<ControlChart> charts;
  std::vector<MeanJump> jumps;       ///< by unit
  std::vector<UnusualUnit> unusual;  ///< by unit
  int num_directions = 0;            ///< in which the fleet's lenses vary
};

/// The fewest units of which limits can be told.
constexpr int kFewestFleetUnits = 20;

/// Finds what is unusual in a fleet. Jumps of a mean come first, by the largest
/// change over all places of it, each part searched again. Within the parts,
/// two charts of the lenses themselves: "lens" is Hotelling's T^2 over the
/// principal directions in which lenses vary, "shape" the squared distance from
/// these directions, which no usual lens has. Then a chart for each figure.
///
/// A fleet without outliers or jumps gives an alarm with a chance of 5 %, all
/// charts and units together, and a jump with another 5 %.
///
/// Fewer than kFewestFleetUnits units have no charts.
FleetStatistics FindOutliers(const FleetInput& input);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_STATISTICS_H
