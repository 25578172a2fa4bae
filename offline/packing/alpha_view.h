#ifndef RAYGRID_PACKING_ALPHA_VIEW_H
#define RAYGRID_PACKING_ALPHA_VIEW_H

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "camera/camera_model.h"
#include "packing/view.h"

namespace raygrid {

/// Maximum stretch that an image can represent (StretchAngle()).
inline constexpr double kMaxStretchRad = 85 * M_PI / 180;
/// Maximum stretch of views that are not requested by an angle.
inline constexpr double kDefaultMaxStretchRad = 70 * M_PI / 180;
/// Maximum focal length in px, which blobs store in q16.
inline constexpr double kMaxFocalPx = 65535;

/// A camera, and a view of focal length 1 about (0, 0) that defines the view
/// direction: its pixels are points of the plane.
struct CameraAndPlane {
  const CameraModel& camera;
  VirtualView plane;
};

/// Returns the stretch of a view at a ray in camera axes.
double Stretch(const VirtualView& plane, const Eigen::Vector3d& ray);

/// A camera's area projected to a plane.
struct AreaOnPlane {
  Eigen::AlignedBox2d box;  ///< bounds of the image circle, within the stretch
                            ///< limit
  double max_stretch_rad = 0;
};
/// Samples the edges of the area and of the image circle, each edge of the area
/// in num_steps steps, and a few interior points.
AreaOnPlane FindAreaOnPlane(const CameraAndPlane& seen, double limit_rad,
                            int num_steps);

/// Makes the view with the given point of the plane at the image centre.
VirtualView MakeCentralView(const VirtualView& plane, const ImageSize& size,
                            const Eigen::Vector2d& center, double focal_px);

/// Finds the largest view without border that cameras share, with the rotation
/// of the first camera: its focal length is the shortest for which all of its
/// pixels have sources in the areas of all cameras. nullopt if the image
/// centres are outside the areas and no other common point is found.
std::optional<VirtualView> FindLargestViewWithoutBorder(
    const std::vector<CameraAndPlane>& cameras, const ImageSize& size);

/// The smallest view that shows every pixel of the areas of all cameras, with
/// the rotation of the first camera; nullopt if the stretch is too large.
struct EnclosingView {
  std::optional<VirtualView> view;
  double max_stretch_rad = 0;
};
EnclosingView FindSmallestEnclosingView(
    const std::vector<CameraAndPlane>& cameras, const ImageSize& size);

/// Interpolates focal length and principal point between two views.
VirtualView InterpolateViews(const VirtualView& at_0, const VirtualView& at_1,
                             double alpha);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_ALPHA_VIEW_H
