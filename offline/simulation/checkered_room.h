#ifndef RAYGRID_SIMULATION_CHECKERED_ROOM_H
#define RAYGRID_SIMULATION_CHECKERED_ROOM_H

#include "camera/camera_model.h"
#include "dataset/image_files.h"

namespace raygrid {

/// A room around the camera, a cube with checkered walls: straight lines for
/// checking undistortion. Its walls are at a distance of 1 along the camera
/// axes.
///
/// Returns the side of a square, 2 / 2^k, so that about a dozen squares span
/// the image.
double ComputeSceneSquareSize(const CameraModel& camera);

/// Renders the room in BGR by the directions of the camera's pixels: for
/// non-central cameras, as if it were infinitely far. Each wall has its own
/// colour. Pixels outside the calibrated area are grey.
Image RenderCheckeredRoom(const CameraModel& camera, double square,
                          uint8_t not_calibrated, int num_threads);

/// Returns the angle in degrees between the rays at both ends of an image's
/// central row (axis 0) or column (axis 1), summed via its centre; limited to
/// the area.
double ComputeVisibleAngleDeg(const CameraModel& camera, int axis);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_CHECKERED_ROOM_H
