#ifndef RAYGRID_EVALUATION_CAUSE_GROUP_H
#define RAYGRID_EVALUATION_CAUSE_GROUP_H

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "evaluation/cross_fit.h"
#include "evaluation/error_causes.h"
#include "evaluation/residual_budget.h"

namespace raygrid {

struct CauseFit {
  ErrorCause cause;
  CrossFit fit;
};

/// Causes that are estimated from the same halves of the features.
class CauseGroup {
 public:
  /// If poses are given, components along board motions are removed from
  /// simulated errors. Shares are fractions of a sum of squares.
  CauseGroup(std::vector<CauseFit> fits, const PoseComponents* pose,
             double squares)
      : fits_(std::move(fits)), pose_(pose), squares_(squares) {}

  /// Computes the causes' shares. Returns the prediction errors of all
  /// features, each predicted from the other half.
  Eigen::VectorXd Explain(const Eigen::VectorXd& errors,
                          ResidualBudget* budget) const;

  /// Marks the causes, or the control, that explain the units as well as the
  /// largest cause does.
  void FindEquivalentCauses(const Eigen::VectorXd& errors,
                            const CrossFit& control,
                            ResidualBudget* budget) const;

 private:
  using HalfErrors = std::array<Eigen::VectorXd, 2>;

  double Gain(const CrossFit& fit, const HalfErrors& errors) const;
  void EstimateRandomShares(const Eigen::VectorXd& errors,
                            ResidualBudget* budget) const;
  std::optional<size_t> FindNextCause(const HalfErrors& remaining_errors,
                                      const std::vector<bool>& is_removed,
                                      ResidualBudget* budget) const;
  Eigen::VectorXd Join(const HalfErrors& remaining_errors) const;

  std::vector<CauseFit> fits_;
  const PoseComponents* pose_;
  double squares_;
};

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_CAUSE_GROUP_H
