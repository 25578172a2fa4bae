#ifndef RAYGRID_REPORT_ROUND_FIGURES_H
#define RAYGRID_REPORT_ROUND_FIGURES_H

#include <vector>

namespace raygrid {

/// Rounds a positive value up to a round number.
double RoundedUp(double value);

/// Returns three or more ascending, evenly spaced round numbers in the range.
std::vector<double> EvenTicks(double low, double high);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_ROUND_FIGURES_H
