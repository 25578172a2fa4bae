#ifndef RAYGRID_SIMULATION_STRAIGHT_SCENE_H
#define RAYGRID_SIMULATION_STRAIGHT_SCENE_H

#include "camera/camera_model.h"
#include "dataset/image_files.h"

namespace raygrid {

/// A room around the camera, a cube whose walls are checkered: what a picture
/// has to show of straight lines. Its walls lie one unit from the camera along
/// the camera's axes, and each is cut into squares.
///
/// The side of a square, 2 / 2^k, so that about a dozen squares lie across the
/// image.
double SquareOfStraightScene(const CameraModel& camera);

/// The room as a camera sees it, in BGR, by the directions of its pixels: that
/// of non-central cameras as if it were far away. A wall has its own colour.
/// Pixels that are not calibrated get a grey level.
Image RenderStraightScene(const CameraModel& camera, double square,
                          uint8_t not_calibrated, int num_threads);

/// The angle between what the edges of an image's middle row (axis 0) or middle
/// column (axis 1) see, degrees, by way of its middle; of the area, where that
/// ends before.
double SeenAngleDeg(const CameraModel& camera, int axis);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_STRAIGHT_SCENE_H
