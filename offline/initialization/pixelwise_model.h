#ifndef RAYGRID_INITIALIZATION_PIXELWISE_MODEL_H
#define RAYGRID_INITIALIZATION_PIXELWISE_MODEL_H

#include <optional>
#include <vector>

#include "camera/pose.h"
#include "initialization/dense_matches.h"
#include "initialization/triplet_selection.h"

namespace raygrid {

/// A point of a board's plane and the unit direction of its ray.
struct PointRayMatch {
  Eigen::Vector2d point;
  Eigen::Vector3d ray;
};

struct LocalizedBoard {
  Pose camera_from_board;
  double median_error_rad = 0;
};

/// Estimates the pose of a board that faces the camera, for rays in any
/// direction: board-to-ray homography, then minimization of angles (Cauchy
/// loss).
std::optional<LocalizedBoard> LocalizeOnRays(
    const std::vector<PointRayMatch>& matches);

/// A direction for each lattice pixel covered by a localized view, and the
/// views' poses.
struct PixelwiseModel {
  std::vector<std::optional<Eigen::Vector3d>> directions;
  std::vector<std::optional<Pose>> camera_from_board;  ///< per view
  double radians_per_px = 0;                           ///< typical value
  double median_error_px = 0;  ///< median over localized views

  int num_localized() const;
};

/// Grows a per-pixel model from a triplet (paper's supplement, "Calibration
/// initialization"): localizes views with enough overlap and adds directions
/// for the other pixels that they cover; directions are averaged over views.
/// When no view can be added, all are localized again and averaged a few times.
PixelwiseModel GrowPixelwiseModel(const std::vector<DenseView>& views,
                                  const PixelLattice& lattice,
                                  const SolvedTriplet& triplet,
                                  int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_PIXELWISE_MODEL_H
