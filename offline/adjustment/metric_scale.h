#ifndef RAYGRID_ADJUSTMENT_METRIC_SCALE_H
#define RAYGRID_ADJUSTMENT_METRIC_SCALE_H

#include <vector>

#include "adjustment/adjustment_state.h"

namespace raygrid {

/// Neither scale nor frame of a free pattern can be observed. Brings points
/// [first, first + nominal.size()), a board, to its nominal points by the best
/// similarity (Umeyama, 1991), and the poses of the board's views with it, so
/// that no reprojection changes.
void AlignToNominal(int first, const std::vector<Eigen::Vector3d>& nominal,
                    const std::vector<int>& views, AdjustmentState* state);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_METRIC_SCALE_H
