#ifndef RAYGRID_CAPTURE_CAMERA_LINK_H
#define RAYGRID_CAPTURE_CAMERA_LINK_H

#include <memory>
#include <optional>
#include <vector>

#include "camera/camera_model.h"
#include "camera/pose.h"
#include "capture/camera_information.h"
#include "capture/live_camera.h"
#include "capture/pose_derivative.h"
#include "dataset/pattern.h"

namespace raygrid {

/// The relative pose of two cameras of a rig, from boards that both observed in
/// the same frame.
///
/// Each camera determines a board's pose with the information H = J^T J / s^2
/// of its features, with noise s. A board observed by both cameras determines
/// the relative pose with the covariance H_second^-1 + A H_first^-1 A^T, where
/// A is the adjoint of that pose. The information of all boards is added. If
/// the relative poses vary more than predicted, for example due to uncertain
/// intrinsics, the covariance is scaled accordingly.
class CameraLink {
 public:
  /// Returns nullopt if a camera is not calibrated, or if no board was observed
  /// by both cameras in one frame. Images of the same name belong to one frame.
  static std::optional<CameraLink> Of(const LiveCamera& first,
                                      const LiveCamera& second);

  const Pose& second_from_first() const { return second_from_first_; }
  /// Returns the RMS displacement, in the second image, of board points
  /// transferred from the first camera's frame, by the uncertainty of the link.
  double RmsPx() const;

  /// A board's pose in each camera, and its features in each image.
  struct SharedBoard {
    Pose first_from_board, second_from_board;
    std::vector<PointPixelMatch> in_first, in_second;
  };
  /// Computes the fraction by which a board would reduce the variance (RmsPx()
  /// squared). 0 if one camera observes fewer than 8 features.
  double ComputeGain(const SharedBoard& shared) const;
  /// Predicts this fraction for a board at a pose, with simulated features.
  double PredictViewGain(const Board& board,
                         const Pose& first_from_board) const;

 private:
  struct Camera {
    std::shared_ptr<const CameraModel> model;
    double noise_px = 0;
  };

  MotionMatrix ComputeInformation(const SharedBoard& shared) const;
  void EstimateRelativePose(const std::vector<SharedBoard>& boards);
  void EstimateVarianceFactor(const std::vector<SharedBoard>& boards);

  Camera first_, second_;
  Pose second_from_first_;
  double variance_factor_ = 1;  ///< ratio of observed to predicted variance
  MotionMatrix information_ = MotionMatrix::Zero();
  MotionMatrix weighing_ = MotionMatrix::Zero();  // mean D^T D of pixels
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAMERA_LINK_H
