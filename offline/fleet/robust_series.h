/// Figures of a series that jumps and outliers do not change much.
#ifndef RAYGRID_FLEET_ROBUST_SERIES_H
#define RAYGRID_FLEET_ROBUST_SERIES_H

#include <vector>

namespace raygrid {

/// The upper one of two middle values; NaN of none.
double Median(std::vector<double> values);

/// The standard deviation by the differences of neighbours, which neither jumps
/// nor outliers enlarge; 0 of fewer than two known values. NaN is not known.
double DeviationByNeighbours(const std::vector<double>& values);

/// A series with values beyond three deviations from their neighbours' median
/// moved there, so a single one is no jump. Unknown ones, NaN, get the median.
std::vector<double> Clipped(const std::vector<double>& values,
                            double deviation);

/// The median of the part that each value is in; parts begin at cuts, which
/// ascend.
std::vector<double> MiddleOfParts(const std::vector<double>& values,
                                  const std::vector<int>& cuts);

/// The line of least squares through a series' values, clipped first.
std::vector<double> MiddleLine(const std::vector<double>& values);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_ROBUST_SERIES_H
