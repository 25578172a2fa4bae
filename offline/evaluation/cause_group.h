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

/// Causes that are told by the same halves of the features.
class CauseGroup {
 public:
  /// Tossed errors have no part that a motion of the boards explains, if poses
  /// are given. Shares are parts of a sum of squares.
  CauseGroup(std::vector<NamedFit> fits, const PoseParts* pose, double squares)
      : fits_(std::move(fits)), pose_(pose), squares_(squares) {}

  /// Fills in the causes' shares. Returns the errors that are left of each
  /// feature by predictions of the other half.
  Eigen::VectorXd Explain(const Eigen::VectorXd& errors,
                          ResidualBudget* budget) const;

  /// Fills in which causes, or the control, explain units as well as the
  /// largest cause.
  void FindAlike(const Eigen::VectorXd& errors, const CrossFit& control,
                 ResidualBudget* budget) const;

 private:
  using Halves = std::array<Eigen::VectorXd, 2>;

  double Gain(const CrossFit& fit, const Halves& errors) const;
  void MeasureChance(const Eigen::VectorXd& errors,
                     ResidualBudget* budget) const;
  std::optional<size_t> NextCause(const Halves& left,
                                  const std::vector<bool>& is_taken,
                                  ResidualBudget* budget) const;
  Eigen::VectorXd Join(const Halves& left) const;

  std::vector<NamedFit> fits_;
  const PoseParts* pose_;
  double squares_;
};

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_CAUSE_GROUP_H
