#ifndef RAYGRID_FLEET_MEAN_CHANGES_H
#define RAYGRID_FLEET_MEAN_CHANGES_H

#include <string>
#include <vector>

namespace raygrid {

/// The mean of a figure changes from one unit to the next, or that of the
/// lenses along any of the directions in which they vary.
struct MeanJump {
  std::string name;              ///< of the figure, or "lens"
  int unit = 0;                  ///< the first one with the new mean
  double before = 0, after = 0;  ///< middle values of the figure; lenses: 0
  double sigmas = 0;             ///< the change over its standard deviation
};

/// The mean of a figure, or that of the lenses, moves evenly from the first
/// unit to the last one.
struct MeanDrift {
  std::string name;            ///< of the figure, or "lens"
  double first = 0, last = 0;  ///< middle values of the figure; lenses: 0
  double sigmas = 0;           ///< the slope over its standard deviation
};

/// How a mean changes: by jumps, by a drift, or not at all. Names and values
/// are left to the caller.
struct MeanChanges {
  std::vector<MeanJump> jumps;    ///< by unit
  std::vector<MeanDrift> drifts;  ///< one or none
  std::vector<int> Cuts() const;
};

/// Finds how the means of series change together, which have a value for each
/// unit, NaN where it is not known. A jump is where the sum of squares over all
/// series changes most, and each part is searched again. A line takes the
/// place of the jumps where it explains the series better for its number of
/// parameters (BIC).
///
/// Steady series have a jump with half of the chance, and a drift with the
/// other half.
MeanChanges FindMeanChanges(const std::vector<std::vector<double>>& series,
                            double chance);

/// The middle that units scatter about: medians of the parts between jumps, or
/// a line.
std::vector<double> MiddleOf(const std::vector<double>& values,
                             const MeanChanges& changes);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_MEAN_CHANGES_H
