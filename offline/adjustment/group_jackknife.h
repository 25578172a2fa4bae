#ifndef RAYGRID_ADJUSTMENT_GROUP_JACKKNIFE_H
#define RAYGRID_ADJUSTMENT_GROUP_JACKKNIFE_H

#include <Eigen/Core>
#include <vector>

#include "adjustment/linear_response.h"

namespace raygrid {

/// The delete-a-group jackknife of an adjusted state (Shao and Wu, "A General
/// Theory for Jackknife Variance Estimation", 1989): how much the parameters
/// change when a group of frames is left out, by one linear step, beside the
/// change that the adjustment's own model predicts for white noise and its
/// prior. Residuals that are correlated within a frame change the parameters by
/// more, whatever their correlation is like; only frames are assumed to be
/// independent.
class GroupJackknife {
 public:
  /// @param response of the same views, prior, options and state
  /// @param noise_px of adjustment
  GroupJackknife(const LinearResponse& response, const std::vector<View>& views,
                 const GaussianPrior& prior, const AdjustmentOptions& options,
                 const AdjustmentState& state, double noise_px);

  /// Squared changes of linear functions of the parameters: a row a function, a
  /// column a group.
  struct SquaredChanges {
    Eigen::MatrixXd observed, predicted;
  };
  /// @param first of the parameters that the functions depend on
  /// @param jacobian of the functions, a row each
  SquaredChanges Of(int first, const Eigen::MatrixXd& jacobian) const;

  /// False with fewer than three groups, or if the equations are singular.
  bool IsValid() const { return !changes_.empty(); }

 private:
  std::vector<Eigen::MatrixXd> changes_;  // by group: observed, then drawn
};

/// Factors for predicted variances by which predicted and observed squared
/// changes agree. Functions in bands (1, 2, 4, ... of them, largest variance
/// first) have one factor each, shrunk to that of all functions, and that one
/// to 1, the more the fewer independent changes determine them.
struct VarianceFactors {
  explicit VarianceFactors(const GroupJackknife::SquaredChanges& changes);

  double of_all = 1;
  Eigen::VectorXd of_each;
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_GROUP_JACKKNIFE_H
