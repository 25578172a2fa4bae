#ifndef RAYGRID_CALIBRATION_EVEN_SELECTION_H
#define RAYGRID_CALIBRATION_EVEN_SELECTION_H

#include <algorithm>
#include <cstddef>
#include <vector>

namespace raygrid {

/// Selects at most max_count elements with a constant stride.
template <typename T>
std::vector<T> SelectEvenly(const std::vector<T>& all, size_t max_count) {
  const size_t step =
      std::max<size_t>(1, (all.size() + max_count - 1) / max_count);
  std::vector<T> chosen;
  for (size_t i = 0; i < all.size(); i += step) chosen.push_back(all[i]);
  return chosen;
}

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_EVEN_SELECTION_H
