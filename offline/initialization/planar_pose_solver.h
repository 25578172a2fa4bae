#ifndef RAYGRID_INITIALIZATION_PLANAR_POSE_SOLVER_H
#define RAYGRID_INITIALIZATION_PLANAR_POSE_SOLVER_H

#include <array>
#include <vector>

#include "camera/pose.h"

namespace raygrid {

/// The points on a board's plane z = 0, in metres, that three views saw at one
/// and the same pixel.
using BoardPointTriple = std::array<Eigen::Vector2d, 3>;

/// Three views of planar boards, in the first board's frame.
struct ThreeViews {
  /// The board's x and y axes as they are printed, z away from the camera.
  std::array<Pose, 3> first_from_board;
  Eigen::Vector3d center;  ///< of the camera; z < 0

  /// camera_from_board, for camera axes that are the first board's.
  Pose CameraFromBoard(int view) const {
    return {first_from_board[view].rotation,
            first_from_board[view].translation - center};
  }
};

enum class ThreeViewsStatus {
  kSolved,
  kTooFewMatches,
  kParallelBoards,  ///< two of them, or nearly: the distance stays unknown
  kImpossible       ///< no camera in front of three boards sees this
};

struct ThreeViewsSolution {
  ThreeViewsStatus status = ThreeViewsStatus::kTooFewMatches;
  ThreeViews views;
  /// How far from parallel the boards are seen to be: zero if they are.
  double conditioning = 0;
};

/// The relative poses of three views by a central camera of which nothing is
/// known but that each pixel looks along a line: the linear solution of
/// Ramalingam and Sturm (A unifying model for camera calibration, 2016) for
/// planar boards. It is unique: the mirrored one has the camera behind the
/// boards. Single outliers are left out.
ThreeViewsSolution SolveThreeViews(
    const std::vector<BoardPointTriple>& matches);

/// How well three views explain matches, and what is known of the centre.
struct ThreeViewsFit {
  bool converged = false;
  double median_m = 0;  ///< of the distances, the larger one of a match
  /// Standard deviation of the centre, over its distance from the board.
  double center_uncertainty = 0;
};

/// Least squares (Cauchy's loss) over poses and centre, of the distances on the
/// first board between its points and those of the others as the centre sees
/// them there.
ThreeViewsFit RefineThreeViews(const std::vector<BoardPointTriple>& matches,
                               ThreeViews* views);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_PLANAR_POSE_SOLVER_H
