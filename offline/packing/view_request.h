#ifndef RAYGRID_PACKING_VIEW_REQUEST_H
#define RAYGRID_PACKING_VIEW_REQUEST_H

#include <Eigen/Core>
#include <optional>

#include "camera/camera_model.h"
#include "camera/sensor_mode.h"
#include "packing/view.h"

namespace raygrid {

/// A view that is asked for. Of hfov_deg, vfov_deg, focal_px, alpha and like at
/// most one is given, but for the two fields of view together, which then may
/// make pixels that are not square. With none of them it is as sharp in the
/// middle as the camera's image is there, scaled to the size.
struct ViewRequest {
  ImageSize size = {0, 0};  ///< 0 x 0: as the camera's image, or as like
  std::optional<ViewProjection> projection;  ///< a pinhole's, or like's
  /// Yaw, pitch and roll in degrees: see RotationOfAngles().
  std::optional<Eigen::Vector3d> rotate_deg;
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

/// Throws Error(kUsage) for what no camera has such a view of: words that
/// exclude each other, or angles that no image has.
void RequireSensible(const ViewRequest& request);

/// Throws Error(kUsage) for a focal length or a centre that no blob can hold.
void RequireThatBlobsHold(const VirtualView& view);

/// Throws as RequireSensible(), and Error(kUsage) for a view that sees nothing
/// of the camera's area or that a blob cannot hold.
VirtualView MakeView(const CameraModel& camera, const ViewRequest& request);

/// A view of this size that a request tells without a camera: by like, by
/// fields of view or by a focal length. Throws Error(kUsage) for other requests
/// and for what MakeView() throws.
VirtualView MakeViewWithoutCamera(const ImageSize& size,
                                  const ViewRequest& request);

/// The view of frames of another mode. What says nothing of the centre or of a
/// view's turn shows the middle of the frames where it would show that of
/// calibrated ones: a crop stays in the middle.
VirtualView MakeViewOfMode(const CameraModel& camera, const SensorMode& mode,
                           const ViewRequest& request);

/// A pinhole view as large as the camera's image, and just wide enough for what
/// the calibrated area shows less than 70 degrees off the axis. Throws
/// Error(kQuality) if that is nothing, or so far off that a blob cannot hold
/// the view.
VirtualView MakeViewOfArea(const CameraModel& camera);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_VIEW_REQUEST_H
