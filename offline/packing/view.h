#ifndef RAYGRID_PACKING_VIEW_H
#define RAYGRID_PACKING_VIEW_H

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

#include "camera/camera_model.h"
#include "camera/view_projection.h"

namespace raygrid {

/// The virtual camera of an undistorted image, at the real camera's centre.
struct VirtualView {
  ImageSize size;
  ViewProjection projection = ViewProjection::kPinhole;
  Eigen::Vector2d focal_px = Eigen::Vector2d::Zero();   ///< fx, fy
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();  ///< cx, cy
  Eigen::Matrix3d camera_from_view = Eigen::Matrix3d::Identity();

  bool IsTurned() const { return !camera_from_view.isIdentity(0); }

  /// Returns the direction of a pixel in camera axes, of any length; nullopt
  /// for pixels outside the range of the projection.
  std::optional<Eigen::Vector3d> Direction(const Eigen::Vector2d& pixel) const;
  /// Projects a direction in camera axes to a pixel, which may be outside the
  /// image.
  std::optional<Eigen::Vector2d> Pixel(const Eigen::Vector3d& direction) const;

  /// Returns the angles between the outer edges of the first and the last
  /// pixels, along the row and the column of the principal point.
  double HorizontalFieldOfViewDeg() const;
  double VerticalFieldOfViewDeg() const;
};

/// Returns the angle in degrees between the outer edges of an image's first and
/// last pixels along an axis, 0 for x and 1 for y; limited to the range of the
/// projection.
double ComputeFieldOfViewDeg(ViewProjection projection, int axis,
                             double focal_px, double center_px, int pixels);

/// Converts yaw (to the right), then pitch (up), then roll (clockwise),
/// degrees, to the rotation from view axes to camera axes; and back.
Eigen::Matrix3d RotationFromAngles(const Eigen::Vector3d& yaw_pitch_roll_deg);
Eigen::Vector3d RotationToAngles(const Eigen::Matrix3d& camera_from_view);

/// Returns the view as a camera in its own frame, calibrated over its whole
/// image: model opencv without distortion for a pinhole, else a ViewCamera.
std::unique_ptr<CameraModel> MakeViewCamera(const VirtualView& view);

/// Formats a camera file for a view, with the camera's name.
std::string ViewCameraFile(const VirtualView& view, const std::string& name);

/// Returns the view as a camera whose rays are in the original camera's frame.
std::unique_ptr<CameraModel> MakeRotatedViewCamera(const VirtualView& view);

/// Returns the unrotated view that is equivalent to a camera; nullopt for
/// cameras with distortion or another model.
std::optional<VirtualView> MakeCameraView(const CameraModel& camera);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_VIEW_H
