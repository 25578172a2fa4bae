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

struct NamedFit {
  ErrorCause cause;
  CrossFit fit;
};

/// Causes that are estimated from the same halves of the features.
class CauseGroup {
 public:
  /// Simulated errors have no component along board motions if poses are given.
  /// Shares are fractions of a sum of squares.
  CauseGroup(std::vector<NamedFit> fits, const PoseParts* pose, double squares)
      : fits_(std::move(fits)), pose_(pose), squares_(squares) {}

  /// Computes the causes' shares. Returns each feature's error that remains
  /// after prediction from the other half.
  Eigen::VectorXd Explain(const Eigen::VectorXd& errors,
                          ResidualBudget* budget) const;

  /// Marks the causes, or the control, that explain the units as well as the
  /// largest cause does.
  void FindEquivalentCauses(const Eigen::VectorXd& errors,
                            const CrossFit& control,
                            ResidualBudget* budget) const;

 private:
  using Halves = std::array<Eigen::VectorXd, 2>;

  double Gain(const CrossFit& fit, const Halves& errors) const;
  void MeasureChance(const Eigen::VectorXd& errors,
                     ResidualBudget* budget) const;
  std::optional<size_t> FindNextCause(const Halves& left,
                                      const std::vector<bool>& is_taken,
                                      ResidualBudget* budget) const;
  Eigen::VectorXd Join(const Halves& left) const;

  std::vector<NamedFit> fits_;
  const PoseParts* pose_;
  double squares_;
};

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_CAUSE_GROUP_H
