#ifndef RAYGRID_EVALUATION_BOARD_SHAPE_H
#define RAYGRID_EVALUATION_BOARD_SHAPE_H

#include <vector>

#include "dataset/pattern.h"

namespace raygrid {

/// How far a board is from the plane that is nearest to its points, and these
/// from where they are nominally.
struct BoardShape {
  /// Above the plane, by point; not a number where the board has no feature.
  std::vector<double> height_m;
  double rms_height_m = 0, max_height_m = 0;
  /// Within the plane, after the best motion and scale.
  double rms_shift_m = 0;
};

BoardShape MeasureBoardShape(const Board& board);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_BOARD_SHAPE_H
