#ifndef RAYGRID_ADJUSTMENT_GROUP_JACKKNIFE_H
#define RAYGRID_ADJUSTMENT_GROUP_JACKKNIFE_H

#include <Eigen/Core>
#include <vector>

#include "adjustment/linear_response.h"

namespace raygrid {

/// The delete-a-group jackknife (Shao and Wu, "A General Theory for Jackknife
/// Variance Estimation", 1989) of an estimated state: compares the change of
/// the parameters when a group of frames is left out, to first order, with the
/// change predicted for white noise and the prior. Residuals that are
/// correlated within a frame increase the former, regardless of the form of the
/// correlation; only frames are assumed to be independent.
class GroupJackknife {
 public:
  /// @param response of the same views, prior, options and state
  /// @param noise_px standard deviation of the feature noise
  GroupJackknife(const LinearResponse& response, const std::vector<View>& views,
                 const GaussianPrior& prior, const AdjustmentOptions& options,
                 const AdjustmentState& state, double noise_px);

  /// Squared changes of linear functions of the parameters, observed and
  /// predicted: one row per function, one column per group.
  struct SquaredChanges {
    Eigen::MatrixXd observed, predicted;
  };
  /// @param first index of the first parameter of the functions
  /// @param jacobian one row per function
  SquaredChanges Of(int first, const Eigen::MatrixXd& jacobian) const;

  /// Returns false for fewer than three groups or singular equations.
  bool IsValid() const { return !changes_.empty(); }

 private:
  std::vector<Eigen::MatrixXd> changes_;  // one matrix per group, the observed
                                          // one first, then the simulated ones
};

/// Scale factors that match predicted variances to observed squared changes.
/// Functions in bands (of 1, 2, 4, ... functions, in descending order of
/// variance) have a common factor, which is shrunk towards the factor of all
/// functions, and this one towards 1; the fewer independent changes determine a
/// factor, the more it is shrunk.
struct VarianceFactors {
  explicit VarianceFactors(const GroupJackknife::SquaredChanges& changes);

  double overall_factor = 1;
  Eigen::VectorXd group_factors;
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_GROUP_JACKKNIFE_H
