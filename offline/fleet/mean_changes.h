#ifndef RAYGRID_FLEET_MEAN_CHANGES_H
#define RAYGRID_FLEET_MEAN_CHANGES_H

#include <string>
#include <vector>

namespace raygrid {

/// A jump of the mean of a metric between consecutive units, or of the lenses
/// along any of their principal directions.
struct MeanJump {
  std::string name;              ///< metric, or "lens"
  int unit = 0;                  ///< first one with the new mean
  double before = 0, after = 0;  ///< medians of the metric; lenses: 0
  double sigmas = 0;             ///< change over its standard deviation
};

/// A linear drift of the mean of a metric, or of the lenses, from the first
/// unit to the last one.
struct MeanDrift {
  std::string name;            ///< metric, or "lens"
  double first = 0, last = 0;  ///< ends of the line; lenses: 0
  double sigmas = 0;           ///< slope over its standard deviation
};

/// Changes of a mean: jumps, or a drift, or none. The caller sets names and
/// values.
struct MeanChanges {
  std::vector<MeanJump> jumps;    ///< ordered by unit
  std::vector<MeanDrift> drifts;  ///< at most one
  std::vector<int> Cuts() const;
};

/// Finds common changes of the means of several series, each with a value per
/// unit, NaN if unknown. A jump is placed where it reduces the sum of squares
/// over all series most; both sides are searched recursively. A line replaces
/// the jumps if its Bayesian information criterion (BIC) is better.
///
/// For constant series, the false-alarm probability `chance` is divided equally
/// between jumps and drifts.
MeanChanges FindMeanChanges(const std::vector<std::vector<double>>& series,
                            double false_alarm_probability);

/// Returns the trend about which units vary: piecewise medians between jumps,
/// or a line.
std::vector<double> ComputeCenterLine(const std::vector<double>& values,
                                      const MeanChanges& changes);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_MEAN_CHANGES_H
