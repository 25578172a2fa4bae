#ifndef RAYGRID_PACKING_RECTIFICATION_H
#define RAYGRID_PACKING_RECTIFICATION_H

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "camera/camera_model.h"
#include "camera/pose.h"
#include "packing/view.h"

namespace raygrid {

/// A camera of a stereo pair, with its name for errors.
struct StereoCamera {
  std::string name;
  const CameraModel& camera;  ///< must be central
  Pose camera_from_rig;
};

/// A requested rectification.
struct RectificationRequest {
  ImageSize size = {0, 0};  ///< 0 x 0: size of the first camera's image
  /// As in ViewRequest, alpha for both cameras together; at most one is given.
  /// Without either, alpha is 0, and the view is limited to about 120 degrees.
  std::optional<double> alpha, hfov_deg;
};

/// Two pinhole views with equal K and rotation, so that a point has the same
/// row in both, or the same column in a vertical pair.
struct Rectification {
  bool is_vertical = false;          ///< the second camera is below the first
  double baseline_m = 0;             ///< distance between the centres, positive
  std::array<VirtualView, 2> views;  ///< camera_from_view in cameras' frames
  double angle_deg = 0;              ///< angle between the cameras' z axes
  /// Fraction of the first camera's image that overlaps the second one's, at
  /// infinity.
  double overlap = 0;

  /// Returns the rotation from a camera's axes to its view's axes.
  Eigen::Matrix3d R(int camera) const {
    return views[camera].camera_from_view.transpose();
  }
  /// Returns the projection matrices of the views for points in the first
  /// view's axes, and the matrix Q from pixel and disparity to such points, as
  /// in OpenCV's stereoRectify with a common principal point.
  Eigen::Matrix<double, 3, 4> P(int camera) const;
  Eigen::Matrix4d Q() const;
};

/// Computes a rectification. The view axes are the baseline, x for a horizontal
/// and y for a vertical pair, and the perpendicular direction closest to the
/// mean of the cameras' z axes. The pair is vertical if the cameras' y axes
/// indicate it. Alpha 0 is the largest view without border in either camera, 1
/// the smallest that shows all of both. Throws Error(kUsage) for coincident
/// cameras, no overlap, one camera behind the other or in reverse order, and
/// invalid sizes or alphas.
Rectification Rectify(const StereoCamera& first, const StereoCamera& second,
                      const RectificationRequest& request);

/// Whether the second camera is to the left of the first, or above it, in both
/// cameras' images.
bool IsOrderReversed(const Pose& second_from_first);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_RECTIFICATION_H
