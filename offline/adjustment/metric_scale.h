#ifndef RAYGRID_ADJUSTMENT_METRIC_SCALE_H
#define RAYGRID_ADJUSTMENT_METRIC_SCALE_H

#include <vector>

#include "adjustment/adjustment_state.h"

namespace raygrid {

/// A board in a state.
struct AlignedBoard {
  int first = 0;                         ///< of its points
  std::vector<Eigen::Vector3d> nominal;  ///< where they ought to be
  std::vector<int> poses;                ///< that are those of its frame
  /// Boards of one body have one number. Its frame is that of the board whose
  /// place is -1.
  int body = -1;
  int place = -1;  ///< as View::place
};

/// Neither scale nor frame of a free pattern can be observed. Brings boards to
/// their nominal points by the best similarities (Umeyama, 1991), and their
/// poses with them, so that no reprojection changes. With a single camera, each
/// body has a scale of its own; the cameras of a rig tie the boards together:
/// one scale, the boards' mean (weighted by their extent squared), which the
/// rig's cameras follow. With a camera that is not central, whose lines' points
/// would have to scale too, only by the best rigid motions: there the points'
/// prior has held the scale.
void AlignToNominal(const std::vector<AlignedBoard>& boards,
                    AdjustmentState* state);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_METRIC_SCALE_H
