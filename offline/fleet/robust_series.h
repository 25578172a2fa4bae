/// Robust statistics of series with jumps and outliers.
#ifndef RAYGRID_FLEET_ROBUST_SERIES_H
#define RAYGRID_FLEET_ROBUST_SERIES_H

#include <vector>

namespace raygrid {

/// Returns the upper median; NaN if empty.
double Median(std::vector<double> values);

/// Estimates the standard deviation from differences of neighbours, robust to
/// jumps and outliers; 0 for fewer than two known values. NaN: unknown.
double EstimateNeighbourStdDev(const std::vector<double>& values);

/// Clamps values to three standard deviations from the median of their
/// neighbours, so that a single outlier is not mistaken for a jump. Replaces
/// NaN (unknown) by the median.
std::vector<double> ClipOutliers(const std::vector<double>& values,
                                 double deviation);

/// Returns, for each value, the median of its segment. cuts: ascending start
/// indices of the segments.
std::vector<double> ComputeSegmentMedians(const std::vector<double>& values,
                                          const std::vector<int>& cuts);

/// Fits a line to the clipped values of a series by least squares.
std::vector<double> FitRobustLine(const std::vector<double>& values);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_ROBUST_SERIES_H
