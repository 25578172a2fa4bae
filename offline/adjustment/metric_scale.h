#ifndef RAYGRID_ADJUSTMENT_METRIC_SCALE_H
#define RAYGRID_ADJUSTMENT_METRIC_SCALE_H

#include <vector>

#include "adjustment/adjustment_state.h"

namespace raygrid {

/// A board to be aligned to its nominal geometry.
struct AlignedBoard {
  int first = 0;                         ///< index of its first point
  std::vector<Eigen::Vector3d> nominal;  ///< nominal positions (m)
  std::vector<int> poses;                ///< poses of its frame
  /// Boards with the same number form a rigid multi-board target. Its frame is
  /// the frame of the board with place -1.
  int body = -1;
  int place = -1;  ///< see View::place
};

/// Fixes the gauge of an estimated target, whose scale and frame are not
/// observable: aligns boards to their nominal points by similarity transforms
/// (Umeyama, 1991) and updates the poses, so that no reprojection changes. With
/// a single camera, each rigid target has a separate scale; a rig has one
/// common scale, the mean over boards (weighted by their squared extent), which
/// is also applied to the cameras. With non-central cameras, only rigid motions
/// are used: the points of their observation lines would have to be scaled,
/// too, and the prior of the target points determines the scale.
void AlignToNominal(const std::vector<AlignedBoard>& boards,
                    AdjustmentState* state);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_METRIC_SCALE_H
