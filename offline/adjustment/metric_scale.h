#ifndef RAYGRID_ADJUSTMENT_METRIC_SCALE_H
#define RAYGRID_ADJUSTMENT_METRIC_SCALE_H

#include <vector>

#include "adjustment/adjustment_state.h"

namespace raygrid {

/// Neither scale nor frame of a free pattern can be observed. Brings points
/// [first, first + nominal.size()), a board, to its nominal points by the best
/// similarity (Umeyama, 1991), and the board's poses with it, so that no
/// reprojection of a single camera changes. With a camera that is not central,
/// whose lines' points would have to scale too, only by the best rigid motion:
/// there the points' prior has held the scale. Returns its scale, by which the
/// translations of a rig's cameras would have to grow too.
double AlignToNominal(int first, const std::vector<Eigen::Vector3d>& nominal,
                      const std::vector<int>& poses, AdjustmentState* state);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_METRIC_SCALE_H
