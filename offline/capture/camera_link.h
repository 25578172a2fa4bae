#ifndef RAYGRID_CAPTURE_CAMERA_LINK_H
#define RAYGRID_CAPTURE_CAMERA_LINK_H

#include <memory>
#include <optional>
#include <vector>

#include "camera/camera_model.h"
#include "camera/pose.h"
#include "capture/camera_knowledge.h"
#include "capture/live_camera.h"
#include "capture/pose_derivative.h"
#include "dataset/pattern.h"

namespace raygrid {

/// How two cameras of a rig stand to each other, as boards tell it that both
/// saw at one instant.
///
/// Each camera knows a board's pose with the information H = J^T J / s^2 of its
/// features, s the noise. A board seen by two of them gives their relative
/// pose the covariance H_second^-1 + A H_first^-1 A^T, A the adjoint of that
/// pose. Inverted and added up over the boards it is the information. Where the
/// boards' relative poses scatter by more than that, as lenses that are not
/// known well make them, the covariance is as much larger.
class CameraLink {
 public:
  /// Nothing while a camera is not adjusted, or no instant shows a board to
  /// both. Images of one name are of one instant.
  static std::optional<CameraLink> Of(const LiveCamera& first,
                                      const LiveCamera& second);

  const Pose& second_from_first() const { return second_from_first_; }
  /// How far points of the boards so far, as the first camera's frame has them,
  /// may be seen in the second from where they are predicted: root mean square.
  double RmsPx() const;

  /// A board by its pose before each camera, and the features that each sees.
  struct SharedBoard {
    Pose first_from_board, second_from_board;
    std::vector<PointOnPixel> in_first, in_second;
  };
  /// The part of the variance, RmsPx() squared, that a board would take away.
  /// 0 if one camera sees fewer than 8 features.
  double GainOf(const SharedBoard& shared) const;
  /// The gain of a board that the cameras would see in a pose.
  double GainOfView(const Board& board, const Pose& first_from_board) const;

 private:
  struct Camera {
    std::shared_ptr<const CameraModel> model;
    double noise_px = 0;
  };

  MotionMatrix InformationOf(const SharedBoard& shared) const;
  void FindPose(const std::vector<SharedBoard>& boards);
  void FindScatter(const std::vector<SharedBoard>& boards);

  Camera first_, second_;
  Pose second_from_first_;
  double scatter_ =
      1;  ///< of the boards, over what noise alone gives; variance
  MotionMatrix information_ = MotionMatrix::Zero();
  MotionMatrix weighing_ = MotionMatrix::Zero();  // the mean D^T D of pixels
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAMERA_LINK_H
