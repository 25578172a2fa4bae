#ifndef RAYGRID_PACKING_VIEW_H
#define RAYGRID_PACKING_VIEW_H

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "camera/camera_model.h"
#include "camera/view_projection.h"

namespace raygrid {

/// The virtual camera that an undistorted image seems to come from. It stands
/// where the real one does.
struct VirtualView {
  ImageSize size;
  ViewProjection projection = ViewProjection::kPinhole;
  Eigen::Vector2d focal_px = Eigen::Vector2d::Zero();   ///< fx, fy
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();  ///< cx, cy
  Eigen::Matrix3d camera_from_view = Eigen::Matrix3d::Identity();

  bool IsTurned() const { return !camera_from_view.isIdentity(0); }

  /// The direction in camera axes, of any length, that a pixel looks along;
  /// nothing for pixels beyond what the projection shows.
  std::optional<Eigen::Vector3d> Direction(const Eigen::Vector2d& pixel) const;
  /// The pixel, also of those beyond the image, that looks along a direction in
  /// camera axes.
  std::optional<Eigen::Vector2d> Pixel(const Eigen::Vector3d& direction) const;

  /// Between the outer edges of the first and the last pixels, along the row
  /// and the column of the centre.
  double HorizontalFieldOfViewDeg() const;
  double VerticalFieldOfViewDeg() const;
};

/// The angle between the outer edges of an image's first and last pixels along
/// an axis, 0 for x and 1 for y, in degrees; of an image beyond the ends of its
/// projection, between these.
double FieldOfViewDeg(ViewProjection projection, int axis, double focal_px,
                      double center_px, int pixels);

/// Turns a view to the right, then up, then clockwise, in degrees: axes of the
/// view to camera axes.
Eigen::Matrix3d RotationOfAngles(const Eigen::Vector3d& yaw_pitch_roll_deg);
Eigen::Vector3d AnglesOfRotation(const Eigen::Matrix3d& camera_from_view);

/// The view as a camera in its own axes, calibrated over its whole image: of a
/// pinhole the model opencv without distortion, otherwise a ViewCamera.
std::unique_ptr<CameraModel> CameraOfView(const VirtualView& view);

/// A view as a camera in the axes of the one that it is made from.
std::unique_ptr<CameraModel> CameraOfTurnedView(const VirtualView& view);

/// The view, not turned, that such a camera is; nothing if it has distortion or
/// is of another model.
std::optional<VirtualView> ViewOfCamera(const CameraModel& camera);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_VIEW_H
