#ifndef RAYGRID_PACKING_VIEW_REQUEST_H
#define RAYGRID_PACKING_VIEW_REQUEST_H

#include <Eigen/Core>
#include <optional>

#include "camera/camera_model.h"
#include "camera/sensor_mode.h"
#include "packing/view.h"

namespace raygrid {

/// A requested view. At most one of hfov_deg, vfov_deg, focal_px, alpha and
/// like may be set, except for both fields of view together, which may result
/// in non-square pixels. Without any, the view has the resolution of the
/// camera's image centre, scaled to the size.
struct ViewRequest {
  ImageSize size = {0, 0};                   ///< 0 x 0: the camera's, or like's
  std::optional<ViewProjection> projection;  ///< default: pinhole, or like's
  /// Yaw, pitch and roll in degrees: see RotationFromAngles().
  std::optional<Eigen::Vector3d> rotate_deg;
  std::optional<double> hfov_deg, vfov_deg;
  std::optional<double> focal_px;
  /// OpenCV's alpha, with square pixels: 0 is the largest view without border,
  /// 1 the smallest that shows every pixel of the area; focal length and
  /// principal point are interpolated linearly.
  std::optional<double> alpha;
  /// Principal point: cx, cy. Default: the image centre; not with alpha, which
  /// determines it.
  std::optional<Eigen::Vector2d> center_px;
  std::optional<VirtualView> like;  ///< view to copy, scaled to the size
};

/// Throws Error(kUsage) for requests that no camera can satisfy: mutually
/// exclusive options, or impossible angles.
void RequireValidView(const ViewRequest& request);

/// Throws Error(kUsage) for a focal length or principal point that no blob can
/// store.
void RequirePackableView(const VirtualView& view);

/// Makes a view. Throws like RequireValidView(), and Error(kUsage) for a view
/// that does not overlap the calibrated area or that a blob cannot store.
VirtualView MakeView(const CameraModel& camera, const ViewRequest& request);

/// Makes a view of this size without a camera: from like, fields of view or a
/// focal length. Throws Error(kUsage) for other requests, and like MakeView().
VirtualView MakeViewWithoutCamera(const ImageSize& size,
                                  const ViewRequest& request);

/// Makes the view for frames of another mode. If neither principal point nor
/// rotation is specified, it shows the centre of these frames instead of the
/// centre of calibrated frames: a crop stays centred.
VirtualView MakeModeView(const CameraModel& camera, const SensorMode& mode,
                         const ViewRequest& request);

/// Makes a pinhole view of the camera's image size that just covers the part of
/// the calibrated area within 70 degrees of the axis. Throws
/// Error(kQualityTooLow) if this part is empty, or so far from the axis that a
/// blob cannot store the view.
VirtualView MakeAreaView(const CameraModel& camera);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_VIEW_REQUEST_H
