#ifndef RAYGRID_INITIALIZATION_MEDIAN_H
#define RAYGRID_INITIALIZATION_MEDIAN_H

#include <algorithm>
#include <vector>

namespace raygrid {

/// The value in the middle, the upper one of two; 0 of no values.
inline double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_MEDIAN_H
