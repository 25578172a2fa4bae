#ifndef RAYGRID_ADJUSTMENT_REPROJECTION_ERROR_H
#define RAYGRID_ADJUSTMENT_REPROJECTION_ERROR_H

#include <Eigen/Core>
#include <vector>

#include "adjustment/adjustment_state.h"

namespace raygrid {

/// Margin around the calibrated area (px) within which residuals are defined
/// during optimization. The area is the bounding rectangle of the features, so
/// the projections of the outermost ones may lie outside.
constexpr double kAdjustmentMarginPx = 3;

/// A residual r = projection - observation (px), invalid if the point does not
/// project into the area (paper, "Bundle Adjustment").
struct Residual {
  bool valid = false;
  Eigen::Vector2d error_px = Eigen::Vector2d::Zero();
};

/// A residual with its Jacobians.
struct LinearizedResidual {
  Residual residual;
  int camera = 0, pose = 0, place = -1, point = 0;
  /// J_pose with respect to the updates of UpdatedPose() of camera_from_rig,
  /// rig_from_pattern and target_from_board (the last for boards of rigid
  /// targets).
  Eigen::Matrix<double, 2, 6> J_camera_pose, J_pose, J_board_pose;
  Eigen::Matrix<double, 2, 3> J_point;
  /// Jacobian with respect to the per-view deformation. For static deformation,
  /// which moves the point, it is J_point times DeformationModes::J_point.
  Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, DeformationModes::kMaxCount>
      J_deformation;
  LinearizedProjection projection;  ///< with the Jacobian of the intrinsics
};

/// Computes all residuals, view by view; deterministic with threads.
std::vector<Residual> ComputeResiduals(const AdjustmentState& state,
                                       const std::vector<View>& views,
                                       int num_threads);
/// Computes the linearized residuals of one view.
std::vector<LinearizedResidual> LinearizeView(const AdjustmentState& state,
                                              const View& view);

/// Returns the Huber loss of a residual with this norm, and its weight d loss /
/// d(norm^2 / 2).
double HuberLoss(double norm_px, double huber_px);
double HuberWeight(double norm_px, double huber_px);

/// Returns the variance of a residual's coordinate, with Huber weights.
double ResidualVariance(const std::vector<Residual>& residuals, double huber_px,
                        double num_parameters);

/// Costs of two states over the residuals that are valid in both (paper,
/// "Bundle Adjustment"): otherwise, a state with fewer valid residuals would be
/// preferred.
struct ComparableCosts {
  double first = 0, second = 0;
  int num_common = 0;
};
ComparableCosts CompareCosts(const std::vector<Residual>& first,
                             const std::vector<Residual>& second,
                             double huber_px);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_REPROJECTION_ERROR_H
