#ifndef RAYGRID_INITIALIZATION_MEDIAN_H
#define RAYGRID_INITIALIZATION_MEDIAN_H

#include <algorithm>
#include <vector>

namespace raygrid {

/// Returns the median, or the upper one of both middle values; 0 if empty.
inline double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto median = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), median, values.end());
  return *median;
}

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_MEDIAN_H
