#ifndef RAYGRID_EVALUATION_ERROR_CAUSES_H
#define RAYGRID_EVALUATION_ERROR_CAUSES_H

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "evaluation/cross_fit.h"
#include "evaluation/residual_budget.h"

namespace raygrid {

/// The components of errors along the motions of each view's board.
class PoseComponents {
 public:
  explicit PoseComponents(const BudgetInput& input);

  /// Removes these components from errors, or from each row of columns (k x 2
  /// features).
  void Remove(Eigen::VectorXd* errors) const;
  void RemoveFromRows(Eigen::MatrixXd* columns) const;

 private:
  struct ViewTerms {
    Eigen::Index first = 0;
    Eigen::MatrixXd basis;  // orthonormal columns
  };
  std::vector<ViewTerms> views_;
};

/// Errors shared by features in one region of the image, or at one target
/// point. Halves are blocks of views that are consecutive in time.
LinearCauseModel MakeImagePositionCauseModel(const BudgetInput& input);
LinearCauseModel MakeBoardPositionCauseModel(const BudgetInput& input);

/// Errors specific to a view beyond the board's motion. Halves are blocks of
/// the board's lattice, in a checkerboard. nullopt for boards without
/// deformation modes.
std::optional<LinearCauseModel> MakeViewCauseModel(ErrorCause cause,
                                                   const BudgetInput& input,
                                                   const PoseComponents& pose);

/// Motion during a column-wise readout, as a control for the line delay.
LinearCauseModel MakeColumnDelayControl(const BudgetInput& input,
                                        const PoseComponents& pose);

/// Minimum number of features of a view that is used as a unit.
constexpr int kMinBudgetViewFeatures = 24;
std::vector<int> CountFeaturesByView(const BudgetInput& input);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_ERROR_CAUSES_H
