#ifndef RAYGRID_ADJUSTMENT_REPROJECTION_ERROR_H
#define RAYGRID_ADJUSTMENT_REPROJECTION_ERROR_H

#include <Eigen/Core>
#include <vector>

#include "adjustment/adjustment_state.h"

namespace raygrid {

/// How far beyond the calibrated area a residual may still be formed during
/// adjustment: the area is spanned by features, whose projections scatter
/// around its edge.
constexpr double kAdjustmentMarginPx = 3;

/// A residual r = projection - observation (paper, "Bundle Adjustment"), or
/// none, where the point does not project into the area.
struct Residual {
  bool valid = false;
  Eigen::Vector2d error_px = Eigen::Vector2d::Zero();
};

/// A residual with its derivatives by everything it depends on.
struct LinearizedResidual {
  Residual residual;
  int camera = 0, pose = 0, place = -1, point = 0;
  /// The derivatives by the updates of UpdatedPose() of camera_from_rig,
  /// rig_from_pattern and body_from_board, the last where the view has a place.
  Eigen::Matrix<double, 2, 6> by_camera_pose, by_pose, by_place;
  Eigen::Matrix<double, 2, 3> by_point;
  /// By the bends of the pose. Those that boards have in all views move the
  /// point: their derivatives are by_point times FlexModes::by_point.
  Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, FlexModes::kMaxCount> by_flex;
  LinearizedProjection projection;  ///< derivatives by the camera's parameters
};

/// All residuals, view by view. Same result for any number of threads.
std::vector<Residual> ComputeResiduals(const AdjustmentState& state,
                                       const std::vector<View>& views,
                                       int num_threads);
/// The linearized residuals of one view.
std::vector<LinearizedResidual> LinearizeView(const AdjustmentState& state,
                                              const View& view);

/// Huber's loss of a residual of this norm, and its weight
/// d loss / d(norm^2 / 2).
double HuberLoss(double norm_px, double huber_px);
double HuberWeight(double norm_px, double huber_px);

/// The variance of a residual's coordinate, with the loss's weights.
double ResidualVariance(const std::vector<Residual>& residuals, double huber_px,
                        double num_parameters);

/// Sums of the losses of two states over the residuals that are valid in both
/// (paper, "Bundle Adjustment"): anything else would favour a state that loses
/// residuals over one that gains some.
struct ComparableCosts {
  double first = 0, second = 0;
  int num_common = 0;
};
ComparableCosts CompareCosts(const std::vector<Residual>& first,
                             const std::vector<Residual>& second,
                             double huber_px);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_REPROJECTION_ERROR_H
