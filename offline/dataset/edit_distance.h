#ifndef RAYGRID_DATASET_EDIT_DISTANCE_H
#define RAYGRID_DATASET_EDIT_DISTANCE_H

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

namespace raygrid {

/// Returns the Levenshtein distance.
inline size_t CountEdits(const std::string& from, const std::string& to) {
  std::vector<size_t> row(to.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (size_t i = 0; i < from.size(); ++i) {
    size_t diagonal = row[0]++;
    for (size_t j = 0; j < to.size(); ++j) {
      const size_t replaced = diagonal + (from[i] != to[j] ? 1 : 0);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

}  // namespace raygrid

#endif  // RAYGRID_DATASET_EDIT_DISTANCE_H
