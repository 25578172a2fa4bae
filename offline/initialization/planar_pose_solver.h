#ifndef RAYGRID_INITIALIZATION_PLANAR_POSE_SOLVER_H
#define RAYGRID_INITIALIZATION_PLANAR_POSE_SOLVER_H

#include <array>
#include <vector>

#include "camera/pose.h"

namespace raygrid {

/// Points on a board's plane z = 0, in metres, observed at the same pixel in
/// three views.
using BoardPointTriple = std::array<Eigen::Vector2d, 3>;

/// Poses of three views of planar boards, in the first board's frame.
struct ThreeViews {
  /// Board axes: x and y as printed, z away from the camera.
  std::array<Pose, 3> first_from_board;
  Eigen::Vector3d center;  ///< camera centre; z < 0

  /// Returns camera_from_board, with camera axes parallel to those of the first
  /// board.
  Pose CameraFromBoard(int view) const {
    return {first_from_board[view].rotation,
            first_from_board[view].translation - center};
  }
};

enum class ThreeViewsStatus {
  kSolved,
  kTooFewMatches,
  kParallelBoards,  ///< or nearly parallel: distance not observable
  kImpossible       ///< no camera in front of the boards exists
};

struct ThreeViewsSolution {
  ThreeViewsStatus status = ThreeViewsStatus::kTooFewMatches;
  ThreeViews views;
  /// Measure of the angles between the boards: zero if parallel.
  double conditioning = 0;
};

/// Estimates the relative poses of three views of planar boards for a central
/// camera with an unknown line per pixel: the linear solution of Ramalingam and
/// Sturm ("A unifying model for camera calibration", 2016). It is unique, as
/// its mirror image has the camera behind the boards. Rejects single outliers.
ThreeViewsSolution SolveThreeViews(
    const std::vector<BoardPointTriple>& matches);

/// The fit of three views to their matches, and the centre's uncertainty.
struct ThreeViewsFit {
  bool converged = false;
  double median_m = 0;  ///< median over matches of the larger distance
  /// Standard deviation of the centre, relative to its distance from the board.
  double center_uncertainty = 0;
};

/// Minimizes, over poses and centre, the distances on the first board between
/// its points and the points of the other boards projected through the centre
/// (Cauchy loss).
ThreeViewsFit RefineThreeViews(const std::vector<BoardPointTriple>& matches,
                               ThreeViews* views);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_PLANAR_POSE_SOLVER_H
