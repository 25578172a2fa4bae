#ifndef RAYGRID_EVALUATION_BUDGET_VERDICT_H
#define RAYGRID_EVALUATION_BUDGET_VERDICT_H

#include <string>

#include "evaluation/residual_budget.h"

namespace raygrid {

/// The limit of a calibration: a name as in the table ("noise", "outliers",
/// "per-view effects", "unexplained", or a cause's), a sentence, and the most
/// effective remedy.
struct BudgetVerdict {
  std::string limit, sentence, advice;
  bool IsTold() const { return !limit.empty(); }
  bool IsCause() const {
    return IsTold() && limit != "noise" && limit != "unexplained";
  }
};

/// A cause that explains a tenth of the squared residuals comes before noise:
/// noise is averaged away by more features, errors that features share are not.
BudgetVerdict JudgeBudget(const ResidualBudget& budget);

/// The things to do against errors that neighbours share, and of which no cause
/// is told: nothing that was done already.
std::string AdviceAgainstSharedErrors(const BudgetFacts& facts);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_BUDGET_VERDICT_H
