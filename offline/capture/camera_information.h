#ifndef RAYGRID_CAPTURE_CAMERA_INFORMATION_H
#define RAYGRID_CAPTURE_CAMERA_INFORMATION_H

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "calibration/model_adjustment.h"
#include "dataset/pattern.h"
#include "initialization/localization.h"

namespace raygrid {

/// Returns the area in which features can be detected: a feature's window must
/// be within the image.
Area GetFeatureArea(const ImageSize& size);

/// Simulates the detection of a board's features, in the board frame.
std::vector<PointPixelMatch> PredictVisiblePoints(
    const CameraModel& camera, const Board& board,
    const Pose& camera_from_board);

/// A pixel with its predicted uncertainty: the RMS displacement of its ray's
/// projection.
struct UncertaintySample {
  Eigen::Vector2d pixel;
  double stddev_px = 0;
};

/// The predicted uncertainty of a camera from the images so far, and its
/// reduction by one more image.
///
/// With H = P + sum over views of J^T J, the prior's Hessian P, each view's
/// pose eliminated from J, and D the Jacobian of pixels with respect to the
/// parameters, the pixels have the covariance s^2 D H^-1 D^T. A view with
/// Jacobian J' reduces it by s^2 D H^-1 J'^T (1 + J' H^-1 J'^T)^-1 J' H^-1 D^T.
/// Boards have their nominal geometry.
class CameraInformation {
 public:
  /// Computes the uncertainty of a calibrated camera; nullopt if the normal
  /// equations are singular.
  static std::optional<CameraInformation> Of(const AdjustmentResult& adjusted);

  const CameraModel& camera() const { return *camera_; }
  /// Returns a lattice over the image, row by row, where the camera is defined.
  const std::vector<UncertaintySample>& places() const { return positions_; }
  /// Returns the square root of the mean variance over the lattice.
  double RmsPx() const;
  /// Returns the 95 % quantile of the standard deviations.
  double Percentile95Px() const;

  /// Predicts the fraction, 0 to 1, by which a view of a board at
  /// camera_from_board would reduce the mean variance, with the features that
  /// would be detected.
  double PredictViewGain(const Board& board,
                         const Pose& camera_from_board) const;
  /// Computes the same fraction for the observed features of an image.
  double ComputeGain(const std::vector<Eigen::Vector3d>& points,
                     const std::vector<Eigen::Vector2d>& pixels,
                     const Pose& camera_from_points) const;

 private:
  CameraInformation() = default;

  std::unique_ptr<CameraModel> camera_;
  std::vector<UncertaintySample> positions_;
  Eigen::MatrixXd inverse_;   // H^-1
  Eigen::MatrixXd weighing_;  // H^-1 D^T D H^-1 / tr(D H^-1 D^T)
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAMERA_INFORMATION_H
