/// Normal equations of one frame with a moving board.
#ifndef RAYGRID_SHUTTER_FRAME_EQUATIONS_H
#define RAYGRID_SHUTTER_FRAME_EQUATIONS_H

#include <Eigen/Core>
#include <vector>

#include "camera/camera_model.h"
#include "shutter/board_tracks.h"

namespace raygrid {

/// Frames share the line delay; two polynomials of degree four in the image,
/// for a bias of the camera; and three of degree three on the board, for its
/// deformation. A motion common to all frames would bias camera and target in
/// this way, and does not determine the line delay.
constexpr int kImageTerms = 15, kBoardTerms = 10;
constexpr int kNumFrameParameters = 1 + 2 * kImageTerms,
              kNumBoardParameters = 3 * kBoardTerms;
constexpr int kShared = kNumFrameParameters + kNumBoardParameters;
using SharedVector = Eigen::Matrix<double, kShared, 1>;
using SharedMatrix = Eigen::Matrix<double, kShared, kShared>;

/// The observations of a frame, and the variables on which they depend.
struct FrameInput {
  const CameraModel* camera = nullptr;
  const std::vector<TrackPoint>* points = nullptr;
  Pose pose;  ///< at the central row
  FrameMotion motion;
  double half_m = 0;    ///< half of the board's longer side
  SharedVector shared;  ///< line delay; px; fractions of half_m
};

/// Returns the row whose readout time is the time of the frame.
double GetReferenceRow(const ImageSize& size);

/// Maximum distance (px) of projections outside the calibrated area.
constexpr double kShutterMarginPx = 3;

struct FrameEquations {
  Matrix6d pose = Matrix6d::Zero(), pose_covariance = Matrix6d::Zero();
  /// Information on the pose, weighted by the distance of rows from the central
  /// one, and by its square.
  Matrix6d by_row = Matrix6d::Zero(), by_row2 = Matrix6d::Zero();
  Eigen::Matrix<double, 6, kShared> mixed =
      Eigen::Matrix<double, 6, kShared>::Zero();
  Vector6d pose_gradient = Vector6d::Zero();
  /// Gradient of the shared parameters, after eliminating the pose.
  SharedVector gradient = SharedVector::Zero();
  double squares = 0;  ///< sum of squared residuals, px^2, with Huber weights
  int num_points = 0;

  /// Returns the step of the pose for a step of the shared parameters.
  Vector6d PoseStep(const SharedVector& change) const {
    return -pose_covariance * (pose_gradient + mixed * change);
  }
  /// Returns the information on the velocity, for a line delay of 1.
  Matrix6d VelocityInformation() const {
    return by_row2 - by_row * pose_covariance * by_row;
  }
};

/// Returns the equations of a frame, and adds the information on the shared
/// parameters, after eliminating the pose, to *information.
FrameEquations MakeFrameEquations(const FrameInput& input,
                                  SharedMatrix* information);

}  // namespace raygrid

#endif  // RAYGRID_SHUTTER_FRAME_EQUATIONS_H
