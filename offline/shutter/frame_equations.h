/// The normal equations of one frame in which a board moves.
#ifndef RAYGRID_SHUTTER_FRAME_EQUATIONS_H
#define RAYGRID_SHUTTER_FRAME_EQUATIONS_H

#include <Eigen/Core>
#include <vector>

#include "camera/camera_model.h"
#include "shutter/board_tracks.h"

namespace raygrid {

/// Frames share the row time; what the camera may yet be bent by, two
/// polynomials of the fourth degree in the image; and what the board may be
/// bent by, three of the third degree on it. A motion that all frames have
/// alike would bend a camera or a board like that, and tells no row time.
constexpr int kImageTerms = 15, kBoardTerms = 10;
constexpr int kOfAllFrames = 1 + 2 * kImageTerms, kOfBoard = 3 * kBoardTerms;
constexpr int kShared = kOfAllFrames + kOfBoard;
using SharedVector = Eigen::Matrix<double, kShared, 1>;
using SharedMatrix = Eigen::Matrix<double, kShared, kShared>;

/// A frame of a track, and what it depends on.
struct FrameInput {
  const CameraModel* camera = nullptr;
  const std::vector<TrackPoint>* points = nullptr;
  Pose pose;  ///< when the middle row is read
  FrameMotion motion;
  double half_m = 0;    ///< of the board's longer side
  SharedVector shared;  ///< row time; bends in pixels, then parts of half_m
};

/// The row that stands for a frame.
double MiddleRow(const ImageSize& size);

/// How far beyond the calibrated area features may be projected.
constexpr double kShutterMarginPx = 3;

struct FrameEquations {
  Matrix6d pose = Matrix6d::Zero(), pose_covariance = Matrix6d::Zero();
  /// The information on the pose, times rows from the middle one, and times
  /// their squares.
  Matrix6d by_row = Matrix6d::Zero(), by_row2 = Matrix6d::Zero();
  Eigen::Matrix<double, 6, kShared> mixed =
      Eigen::Matrix<double, 6, kShared>::Zero();
  Vector6d pose_gradient = Vector6d::Zero();
  /// By what is shared, once the pose has followed.
  SharedVector gradient = SharedVector::Zero();
  double squares = 0;  ///< px^2, weighted as adjustments do
  int num_points = 0;

  /// The step of the pose when what is shared changes.
  Vector6d PoseStep(const SharedVector& change) const {
    return -pose_covariance * (pose_gradient + mixed * change);
  }
  /// The information on a velocity, for a row time of 1.
  Matrix6d OnVelocity() const {
    return by_row2 - by_row * pose_covariance * by_row;
  }
};

/// Adds the information on what is shared, once the pose has followed, to
/// *information.
FrameEquations MakeFrameEquations(const FrameInput& input,
                                  SharedMatrix* information);

}  // namespace raygrid

#endif  // RAYGRID_SHUTTER_FRAME_EQUATIONS_H
