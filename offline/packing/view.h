#ifndef RAYGRID_PACKING_VIEW_H
#define RAYGRID_PACKING_VIEW_H

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "camera/camera_model.h"

namespace raygrid {

/// The pinhole camera that an undistorted image seems to come from: same place
/// and orientation as the real one.
struct VirtualView {
  ImageSize size;
  Eigen::Vector2d focal_px = Eigen::Vector2d::Zero();   ///< fx, fy
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();  ///< cx, cy

  /// The direction that a pixel looks along, of any length.
  Eigen::Vector3d Direction(const Eigen::Vector2d& pixel) const {
    return {(pixel.x() - center_px.x()) / focal_px.x(),
            (pixel.y() - center_px.y()) / focal_px.y(), 1};
  }
  /// The pixel, also of those beyond the image, that looks along a direction;
  /// nothing behind.
  std::optional<Eigen::Vector2d> Pixel(const Eigen::Vector3d& direction) const;

  /// Between the outer edges of the first and the last pixels.
  double HorizontalFieldOfViewDeg() const;
  double VerticalFieldOfViewDeg() const;
};

/// A view that is asked for. Of hfov_deg, vfov_deg, focal_px, alpha and like at
/// most one is given, but for the two fields of view together, which then may
/// make pixels that are not square. With none of them it is as sharp in the
/// middle as the camera's image is there, scaled to the size.
struct ViewRequest {
  ImageSize size = {0, 0};  ///< 0 x 0: as the camera's image, or as like
  std::optional<double> hfov_deg, vfov_deg;
  std::optional<double> focal_px;
  /// The alpha of OpenCV's users, with square pixels: 0 is the largest view
  /// without border, 1 the smallest that shows every pixel of the area; focal
  /// length and centre are between these in proportion.
  std::optional<double> alpha;
  /// The pixel that looks straight ahead: cx, cy. The middle, if it is not
  /// given; alpha has one of its own.
  std::optional<Eigen::Vector2d> center_px;
  std::optional<VirtualView> like;  ///< scaled to the size
};

/// Throws Error(kUsage) for a view that no pinhole has, that sees nothing of
/// the camera's area, or that a blob cannot hold.
VirtualView MakeView(const CameraModel& camera, const ViewRequest& request);

/// A view as large as the camera's image, and just wide enough for what the
/// calibrated area shows less than 70 degrees off the axis. Throws
/// Error(kQuality) if that is nothing, or so far off that a blob cannot hold
/// the view.
VirtualView MakeViewOfArea(const CameraModel& camera);

/// The view as a camera: the model "opencv" without distortion, calibrated over
/// its whole image.
std::unique_ptr<CameraModel> CameraOfView(const VirtualView& view);

/// The view that such a camera is; nothing if it has distortion or is of
/// another model.
std::optional<VirtualView> ViewOfCamera(const CameraModel& camera);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_VIEW_H
