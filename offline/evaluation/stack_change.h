#ifndef RAYGRID_EVALUATION_STACK_CHANGE_H
#define RAYGRID_EVALUATION_STACK_CHANGE_H

#include <Eigen/Core>
#include <vector>

#include "camera/camera_stack.h"

namespace raygrid {

/// How the image of a far scene differs at a value of a stack's condition, its
/// only one, from that in the middle of the range.
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

/// The centres of cells that an area is divided into, row by row.
std::vector<Eigen::Vector2d> PlacesOver(const Area& area, int columns,
                                        int rows);

/// How far the images of far points move, in px, from pixels of a camera to
/// another one of its stack, without the growth and the shift that explain most
/// of it; not a number where one of the two does not see them.
std::vector<Eigen::Vector2d> MeasureDistortion(
    const CentralGeneric& from, const CentralGeneric& to,
    const std::vector<Eigen::Vector2d>& pixels);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_STACK_CHANGE_H
