#ifndef RAYGRID_REPORT_ROUND_FIGURES_H
#define RAYGRID_REPORT_ROUND_FIGURES_H

#include <vector>

namespace raygrid {

/// A round number, no less than a value above 0.
double RoundedUp(double value);

/// Round numbers in even steps within low to high, three at least, ascending.
std::vector<double> EvenTicks(double low, double high);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_ROUND_FIGURES_H
