#ifndef RAYGRID_INITIALIZATION_PIXELWISE_MODEL_H
#define RAYGRID_INITIALIZATION_PIXELWISE_MODEL_H

#include <optional>
#include <vector>

#include "camera/pose.h"
#include "initialization/dense_matches.h"
#include "initialization/triplet_selection.h"

namespace raygrid {

/// A point of a board's plane and the unit direction that it is seen along.
struct PointOnRay {
  Eigen::Vector2d point;
  Eigen::Vector3d ray;
};

struct LocalizedBoard {
  Pose camera_from_board;
  double median_error_rad = 0;
};

/// The pose of a board seen from its front, for rays in any direction: the
/// homography from board to rays, then the least angles (Cauchy's loss).
std::optional<LocalizedBoard> LocalizeOnRays(
    const std::vector<PointOnRay>& matches);

/// A direction for each pixel of a lattice that a localised view covers, and
/// the views' poses.
struct PixelwiseModel {
  std::vector<std::optional<Eigen::Vector3d>> directions;
  std::vector<std::optional<Pose>> camera_from_board;  ///< of each view
  double radians_per_px = 0;                           ///< typically
  double median_error_px = 0;  ///< of directions, within localised views

  int num_localized() const;
};

/// Grows a model from a triplet (paper's supplement, "Calibration
/// initialization"): views that see enough of what has directions are
/// localised, and give directions to what else they cover; directions are
/// averaged over views. Once no view is left to add, all are localised anew
/// and averaged a few times.
PixelwiseModel GrowPixelwiseModel(const std::vector<DenseView>& views,
                                  const PixelLattice& lattice,
                                  const SolvedTriplet& triplet,
                                  int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_PIXELWISE_MODEL_H
