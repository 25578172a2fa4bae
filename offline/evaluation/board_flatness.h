#ifndef RAYGRID_EVALUATION_BOARD_FLATNESS_H
#define RAYGRID_EVALUATION_BOARD_FLATNESS_H

#include <vector>

#include "dataset/pattern.h"

namespace raygrid {

/// A board's deviation from its best-fitting plane, and from its nominal
/// points.
struct BoardFlatness {
  /// Height above the plane, by point; NaN for points without a feature.
  std::vector<double> height_m;
  double rms_height_m = 0, max_height_m = 0;
  /// In-plane deviation after the best similarity transform.
  double rms_shift_m = 0;
};

BoardFlatness MeasureFlatness(const Board& board);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_BOARD_FLATNESS_H
