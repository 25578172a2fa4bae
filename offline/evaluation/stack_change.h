#ifndef RAYGRID_EVALUATION_STACK_CHANGE_H
#define RAYGRID_EVALUATION_STACK_CHANGE_H

#include <Eigen/Core>
#include <vector>

#include "camera/camera_stack.h"

namespace raygrid {

/// How the image of a far scene differs at a value of a stack's condition from
/// that in the middle of the range.
struct StackChange {
  double value = 0;
  double focal_px = 0;  ///< in the middle of the area
  double growth = 0;    ///< 0.01: the image is 1 % larger
  /// Of the nearest lens with radial distortion, which may look elsewhere than
  /// along the z axis.
  Eigen::Vector2d center_px;
  double distortion_px = 0;  ///< RMS of what growth and a shift leave
};

/// The changes at so many values, from one end of the range to the other.
std::vector<StackChange> MeasureStackChanges(const CameraStack& stack,
                                             int num_values);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_STACK_CHANGE_H
