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

/// A camera of a pair, for errors by its name.
struct StereoCamera {
  std::string name;
  const CameraModel& camera;  ///< a central one
  Pose camera_from_rig;
};

/// The pair that is asked for.
struct RectificationRequest {
  ImageSize size = {0, 0};  ///< 0 x 0: as the first camera's image
  /// ViewRequest's, alpha of both cameras together; at most one is given.
  /// Without them alpha is 0, and the view at most about 120 degrees wide.
  std::optional<double> alpha, hfov_deg;
};

/// Two pinhole views with one K that are turned alike, so that a point is seen
/// in the same row of both, or in the same column of a vertical pair.
struct Rectification {
  bool is_vertical = false;          ///< the second camera stands below
  double baseline_m = 0;             ///< from the first to the second, above 0
  std::array<VirtualView, 2> views;  ///< camera_from_view in cameras' frames
  double angle_deg = 0;              ///< between the cameras' z axes
  /// The part of the first camera's image that the second one sees, too, of
  /// what is far away.
  double overlap = 0;

  /// Axes of a camera to those of its view.
  Eigen::Matrix3d R(int camera) const {
    return views[camera].camera_from_view.transpose();
  }
  /// The views' projections of a point in the first view's axes, and the matrix
  /// from pixel and disparity to that point, all as OpenCV's stereoRectify has
  /// them with one principal point for both.
  Eigen::Matrix<double, 3, 4> P(int camera) const;
  Eigen::Matrix4d Q() const;
};

/// The views' axes are the baseline, x of a pair side by side and y of one on
/// top of the other, and the direction across it that is nearest to the mean of
/// the cameras' z axes. It is vertical if the cameras' own y axes say so. Alpha
/// 0 is the largest view of whose pixels none lacks a source in either camera,
/// 1 the smallest that shows all of both. Throws Error(kUsage): cameras at one
/// place, without overlap, one behind the other, or named the wrong way around,
/// and sizes or alphas that cannot be.
Rectification Rectify(const StereoCamera& first, const StereoCamera& second,
                      const RectificationRequest& request);

/// Whether the second camera stands to the left of the first, or above it, in
/// both cameras' images.
bool IsOrderReversed(const Pose& second_from_first);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_RECTIFICATION_H
