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
  /// Boards are bent alike in all views. Adjustments follow the state, which
  /// has modes or none; AdjustModel() sets it up so.
  bool rigid_boards = true;
  double huber_px = 1;       ///< paper, "Bundle Adjustment"
  int max_iterations = 200;  ///< beyond those that learn the prior
  /// Converged when a step lowers the cost by less than this part of it.
  double relative_tolerance = 1e-7;
  /// Converged, too, when several steps in a row lower the cost next to nothing
  /// and move the observed points' images by less than this part of the
  /// standard deviations that the noise gives them.
  double standstill = 0.01;
  int num_threads = 0;
  /// The result is no more than a start: it ends once steps are small beside
  /// those that the next adjustment takes.
  bool is_start = false;
  /// Asked at most once, with a learned prior: when another step would change
  /// residuals and prior by no more than per cents, whether they serve as they
  /// are. Then the adjustment ends.
  std::function<bool(const std::vector<Residual>&)> is_enough;
  /// Asked between iterations; the best state so far stays.
  std::function<bool()> should_stop;
  /// Told each iteration and its cost; iterations start anew when a stage of
  /// adjustment does.
  std::function<void(int iteration, double cost)> progress;
};

struct AdjustmentSummary {
  bool converged = false;
  int num_iterations = 0;
  double initial_cost = 0, final_cost = 0;  ///< each over its valid residuals
  std::vector<Residual> residuals;          ///< of the final state
  /// Standard deviation of a residual's coordinate, with a learned prior.
  double noise_px = 0;
  /// The effective number of parameters, with a learned prior.
  double num_effective = 0;
};

/// Levenberg-Marquardt on the reprojection error over the camera's parameters,
/// the poses of all views and the pattern's points (paper, "Bundle
/// Adjustment"), with a prior. Improves *state in place.
AdjustmentSummary AdjustBundle(const std::vector<View>& views,
                               const GaussianPrior& prior,
                               const AdjustmentOptions& options,
                               AdjustmentState* state);

/// Finds how strong the prior should be, from the data alone: alternates
/// adjustment with the evidence approximation (D. MacKay, "Bayesian
/// Interpolation", 1992, eq. 4.8), which weighs the prior by how far the
/// adjusted parameters depart from its mean and by how many of them the
/// observations determine. Starts with the prior's weights where they are not
/// zero; changes them and *state.
AdjustmentSummary AdjustWithLearnedPrior(const std::vector<View>& views,
                                         const AdjustmentOptions& options,
                                         GaussianPrior* prior,
                                         AdjustmentState* state);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_BUNDLE_ADJUSTMENT_H
