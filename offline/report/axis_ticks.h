#ifndef RAYGRID_REPORT_AXIS_TICKS_H
#define RAYGRID_REPORT_AXIS_TICKS_H

#include <vector>

namespace raygrid {

/// Rounds a positive value up to a round number.
double RoundUp(double value);

/// Returns three or more ascending, evenly spaced round numbers in the range.
std::vector<double> MakeTicks(double low, double high);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_AXIS_TICKS_H
