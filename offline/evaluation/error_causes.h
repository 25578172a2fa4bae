#ifndef RAYGRID_EVALUATION_ERROR_CAUSES_H
#define RAYGRID_EVALUATION_ERROR_CAUSES_H

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "evaluation/cross_fit.h"
#include "evaluation/residual_budget.h"

namespace raygrid {

/// The parts of errors that a motion of each view's board explains.
class PoseParts {
 public:
  explicit PoseParts(const BudgetInput& input);

  /// Takes the part away: of errors, or of each row of columns (k x 2
  /// features).
  void Remove(Eigen::VectorXd* errors) const;
  void RemoveFromRows(Eigen::MatrixXd* columns) const;

 private:
  struct OfView {
    Eigen::Index first = 0;
    Eigen::MatrixXd basis;  // orthonormal columns
  };
  std::vector<OfView> views_;
};

/// The errors that features of one place of the image or point of the board
/// share. Halves are of views: blocks of neighbours in time.
LinearCause ImagePlaceCause(const BudgetInput& input);
LinearCause BoardPlaceCause(const BudgetInput& input);

/// The errors that each view has of its own, beyond the board's motion. Halves
/// are of the board's lattice: blocks in a checkerboard. Nothing for boards
/// without such modes.
std::optional<LinearCause> ViewCause(ErrorCause cause, const BudgetInput& input,
                                     const PoseParts& pose);

/// Motion from column to column, to compare row time with.
LinearCause ColumnTimeControl(const BudgetInput& input, const PoseParts& pose);

/// Views with fewer features are no units.
constexpr int kMinBudgetViewFeatures = 24;
std::vector<int> CountByView(const BudgetInput& input);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_ERROR_CAUSES_H
