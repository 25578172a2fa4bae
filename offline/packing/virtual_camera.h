#ifndef RAYGRID_PACKING_VIRTUAL_CAMERA_H
#define RAYGRID_PACKING_VIRTUAL_CAMERA_H

#include <Eigen/Core>

#include "camera/camera_model.h"

namespace raygrid {

/// The pinhole camera that an undistorted image seems to come from: same place
/// and orientation as the real one.
struct VirtualCamera {
  ImageSize size;
  double focal_px = 0;
  Eigen::Vector2d center;

  Eigen::Vector3d Direction(const Eigen::Vector2d& pixel) const {
    return {(pixel.x() - center.x()) / focal_px,
            (pixel.y() - center.y()) / focal_px, 1};
  }
  double HorizontalFieldOfViewDeg() const;
};

/// size 0 x 0: as the camera's image. hfov_deg 0: as sharp in the middle as the
/// camera's image is there, scaled to the size. Throws Error(kUsage) for a
/// field of view that no pinhole has, or a focal length above 65535 px.
VirtualCamera MakeVirtualCamera(const CameraModel& camera, ImageSize size,
                                double hfov_deg);

/// A view as large as the camera's image, and just wide enough for what the
/// calibrated area shows less than 70 degrees off the axis. Throws
/// Error(kQuality) if that is nothing, or so far off that a blob cannot hold
/// the view.
VirtualCamera MakeVirtualCameraOfArea(const CameraModel& camera);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_VIRTUAL_CAMERA_H
