#ifndef RAYGRID_CAMERA_CAMERA_FRAME_H
#define RAYGRID_CAMERA_CAMERA_FRAME_H

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>

#include "camera/camera_model.h"

namespace raygrid {

/// No observation tells how a grid's frame is turned against the camera's body:
/// all poses would turn with it. By convention it is the frame of the
/// parametric lens nearest to the grid, so that z looks out of the lens's
/// centre, about the middle of the image, and x goes along the rows. A lens has
/// a frame by its equations.
struct CameraFrame {
  std::string lens;  ///< model of the nearest one
  Eigen::Quaterniond frame_from_camera = Eigen::Quaterniond::Identity();

  double AngleRad() const {
    return frame_from_camera.angularDistance(Eigen::Quaterniond::Identity());
  }
};

/// A frame that is turned by less than this is as good as the right one: a
/// fiftieth of a degree.
constexpr double kMaxFrameRotationRad = 0.02 * M_PI / 180;

/// The frame that a camera ought to have; that of a parametric one is its own.
/// Among lenses that are as near to it but for 2 %, the first of those that are
/// compared (camera/lens_models.h) counts. Given a lens, only that one is
/// fitted.
CameraFrame FindCameraFrame(const CameraModel& camera,
                            const std::string& lens = "");

/// A grid in a turned frame, with as many control points. Turning is no linear
/// map of a surface in the chart: the grid is fitted anew, which moves rays by
/// 1e-5 px or so where cells are a tenth of the image. Other cameras are
/// wrapped (camera/rotated_camera.h).
std::unique_ptr<CameraModel> Rotated(
    const CameraModel& camera, const Eigen::Quaterniond& rotated_from_camera);

/// Turns a grid that looks more than a degree off its lens's axes, as earlier
/// calibrations left some, into the frame of its nearest lens. Local distortion
/// moves that frame by less, so that known cameras stay as they are. Returns
/// the rotation of the new frame from the old one, if there was any need.
std::optional<Eigen::Quaterniond> AlignToCameraFrame(
    std::shared_ptr<const CameraModel>* camera);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_FRAME_H
