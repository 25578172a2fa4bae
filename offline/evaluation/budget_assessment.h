#ifndef RAYGRID_EVALUATION_BUDGET_ASSESSMENT_H
#define RAYGRID_EVALUATION_BUDGET_ASSESSMENT_H

#include <string>

#include "evaluation/residual_budget.h"

namespace raygrid {

/// The limit of a calibration: a name as in the table ("noise", "outliers",
/// "per-view effects", "unexplained", or the name of a cause), a sentence, and
/// the most effective remedy.
struct BudgetAssessment {
  std::string limit, sentence, advice;
  bool IsDetermined() const { return !limit.empty(); }
  bool IsCause() const {
    return IsDetermined() && limit != "noise" && limit != "unexplained";
  }
};

/// Finds the limiting cause. A cause of at least a tenth of the squared
/// residuals is reported before noise, because noise averages out over features
/// and correlated errors do not.
BudgetAssessment AssessBudget(const ResidualBudget& budget);

/// Recommends measures against correlated errors without an identified cause;
/// omits measures that were already tried.
std::string AdviseOnCorrelatedErrors(const BudgetSummary& facts);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_BUDGET_ASSESSMENT_H
