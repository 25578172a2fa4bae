#include "report/axis_ticks.h"

#include <cmath>

namespace raygrid {

double RoundUp(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double factor : {1.0, 1.5, 2.0, 3.0, 5.0, 7.5})
    if (factor * power >= value) return factor * power;
  return 10 * power;
}

std::vector<double> MakeTicks(double low, double high) {
  constexpr double kFewest = 3;
  double step = std::pow(10, std::floor(std::log10((high - low) / kFewest)));
  for (const double larger : {2.0, 2.5, 2.0})
    if ((high - low) / (larger * step) >= kFewest) step *= larger;
  std::vector<double> ticks;
  for (double tick = std::ceil(low / step) * step; tick <= high; tick += step)
    ticks.push_back(std::abs(tick) < 1e-6 * step ? 0 : tick);
  return ticks;
}

}  // namespace raygrid
