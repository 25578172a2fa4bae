#ifndef RAYGRID_PACKING_ALPHA_VIEW_H
#define RAYGRID_PACKING_ALPHA_VIEW_H

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "camera/camera_model.h"
#include "packing/view.h"

namespace raygrid {

/// No image has room for what is stretched more (StretchAngle()).
inline constexpr double kMostStretchRad = 85 * M_PI / 180;
/// Views that are not asked for by an angle show less.
inline constexpr double kUsefulStretchRad = 70 * M_PI / 180;
/// The longest focal length in q16, which blobs hold.
inline constexpr double kMaxFocalPx = 65535;

/// A camera, and a view of focal length 1 around (0, 0) that says how it is
/// looked at: its pixels are points of the plane.
struct CameraAndPlane {
  const CameraModel& camera;
  VirtualView plane;
};

/// How much a view stretches what is seen along a ray in camera axes.
double Stretch(const VirtualView& plane, const Eigen::Vector3d& ray);

/// A camera's area as a plane shows it.
struct AreaOnPlane {
  Eigen::AlignedBox2d box;  ///< of what is lit and stretched less than a limit
  double most_stretch_rad = 0;
};
/// By the edges of the area and of the image circle, each edge of the area in
/// as many steps, and a few points within.
AreaOnPlane FindAreaOnPlane(const CameraAndPlane& seen, double limit_rad,
                            int num_steps);

/// The view around a plane's point that lies in the middle of the image.
VirtualView ViewOfMiddle(const VirtualView& plane, const ImageSize& size,
                         const Eigen::Vector2d& middle, double focal_px);

/// The largest view without border that cameras share, turned as that of the
/// first: its focal length is the least at which all of its pixels come from
/// the areas of all cameras. Nothing if the middles of the areas lie outside,
/// and no other common point of theirs is found.
std::optional<VirtualView> LargestWithoutBorder(
    const std::vector<CameraAndPlane>& cameras, const ImageSize& size);

/// The smallest view that shows every pixel of the areas of all cameras, turned
/// as that of the first; nothing if some are stretched too much.
struct ViewOfAll {
  std::optional<VirtualView> view;
  double most_stretch_rad = 0;
};
ViewOfAll SmallestOfAll(const std::vector<CameraAndPlane>& cameras,
                        const ImageSize& size);

/// Focal length and centre between those of two views, in proportion.
VirtualView BetweenViews(const VirtualView& at_0, const VirtualView& at_1,
                         double alpha);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_ALPHA_VIEW_H
