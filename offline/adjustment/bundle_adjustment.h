#ifndef RAYGRID_ADJUSTMENT_BUNDLE_ADJUSTMENT_H
#define RAYGRID_ADJUSTMENT_BUNDLE_ADJUSTMENT_H

#include <functional>
#include <vector>

#include "adjustment/adjustment_state.h"
#include "adjustment/gaussian_prior.h"
#include "adjustment/reprojection_error.h"

namespace raygrid {

struct AdjustmentOptions {
  bool fix_cameras = false;
  bool fix_points = false;
  /// Disables per-view deformation (--rigid-target). Optimization uses the
  /// modes of the state as they are; OptimizeModel() applies this option.
  bool rigid_boards = true;
  double huber_px = 1;       ///< paper, "Bundle Adjustment"
  int max_iterations = 200;  ///< excluding those with evidence maximization
  /// Converged when an iteration lowers the cost by less than this fraction.
  double relative_tolerance = 1e-7;
  /// Also converged when several successive steps barely lower the cost and
  /// move the projections of the observed points by less than this fraction of
  /// their predicted standard deviations.
  double standstill = 0.01;
  int num_threads = 0;
  /// The result only initializes another adjustment: stop once steps are small
  /// compared with the steps of the next adjustment.
  bool is_initialization = false;
  /// Called at most once, after precisions were estimated, when a further step
  /// would change residuals and precisions by at most a few per cent. If it
  /// returns true, the optimization ends with these residuals.
  std::function<bool(const std::vector<Residual>&)> should_accept;
  /// Called between iterations. If it returns true, the optimization stops with
  /// the best state so far.
  std::function<bool()> should_stop;
  /// Called after each iteration with its cost; iterations are counted from the
  /// beginning of each stage.
  std::function<void(int iteration, double cost)> progress;
};

struct AdjustmentSummary {
  bool converged = false;
  int num_iterations = 0;
  double initial_cost = 0, final_cost = 0;  ///< over valid residuals
  std::vector<Residual> residuals;          ///< residuals of the final state
  /// Standard deviation of the feature noise, if precisions were estimated.
  double noise_px = 0;
  /// Effective number of parameters, if precisions were estimated.
  double num_effective = 0;
};

/// Minimizes the objective function of METHOD.md by Levenberg-Marquardt, over
/// camera parameters, poses, deformation and target points, with fixed prior
/// precisions. Updates *state in place.
AdjustmentSummary RunBundleAdjustment(const std::vector<View>& views,
                                      const GaussianPrior& prior,
                                      const AdjustmentOptions& options,
                                      AdjustmentState* state);

/// Also estimates the prior precisions by evidence maximization (D. MacKay,
/// "Bayesian Interpolation", 1992, eq. 4.8): after each Gauss-Newton step, a
/// precision is updated from the squared distance of the parameters to the
/// prior mean and from their effective number. Non-zero precisions in the prior
/// are the initial values. Updates the prior and *state.
AdjustmentSummary OptimizeWithLearnedPrior(const std::vector<View>& views,
                                           const AdjustmentOptions& options,
                                           GaussianPrior* prior,
                                           AdjustmentState* state);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_BUNDLE_ADJUSTMENT_H
