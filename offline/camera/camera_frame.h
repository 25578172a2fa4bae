#ifndef RAYGRID_CAMERA_CAMERA_FRAME_H
#define RAYGRID_CAMERA_CAMERA_FRAME_H

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>

#include "camera/camera_model.h"

namespace raygrid {

/// Canonical frame of a camera. The rotation of a grid's frame is a gauge
/// freedom: all poses compensate for it. By convention it is the frame of the
/// parametric model nearest to the grid, so that z is the optical axis, near
/// the image centre, and x points along the rows. The equations of a parametric
/// model define its frame.
struct CanonicalFrame {
  std::string lens;  ///< name of the nearest parametric model
  Eigen::Quaterniond frame_from_camera = Eigen::Quaterniond::Identity();

  double AngleRad() const {
    return frame_from_camera.angularDistance(Eigen::Quaterniond::Identity());
  }
};

/// Rotations below this, a fiftieth of a degree, are considered identity.
constexpr double kMaxFrameRotationRad = 0.02 * M_PI / 180;

/// Returns the canonical frame of a camera; identity for a parametric model. Of
/// the models that are compared (camera/model_registry.h), a later one is
/// chosen only if its RMS error is at least 2 % smaller. If `lens` is given,
/// only this model is fitted.
CanonicalFrame ComputeCanonicalFrame(const CameraModel& camera,
                                     const std::string& lens = "");

/// Returns a grid in a rotated frame, with the same number of control points.
/// Rotation is not linear in the chart, so the grid is fitted anew, which
/// changes rays by about 1e-5 px for cells of a tenth of the image. Other
/// cameras are wrapped (camera/rotated_camera.h).
std::unique_ptr<CameraModel> Rotated(
    const CameraModel& camera, const Eigen::Quaterniond& rotated_from_camera);

/// Rotates a grid to its canonical frame if it is more than a degree away, as
/// after some earlier calibrations. Local distortion rotates that frame by
/// less, so other calibrated cameras are unchanged. Returns new_from_old, or
/// nullopt if the camera is unchanged.
std::optional<Eigen::Quaterniond> AlignToCanonicalFrame(
    std::shared_ptr<const CameraModel>* camera);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_FRAME_H
