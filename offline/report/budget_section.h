#ifndef RAYGRID_REPORT_BUDGET_SECTION_H
#define RAYGRID_REPORT_BUDGET_SECTION_H

#include <string>

#include "evaluation/residual_budget.h"

namespace raygrid {

/// Formats "What limits this calibration": a sentence, the recommendation, a
/// bar of the fractions of the squared residuals, and their table.
std::string MakeBudgetSection(const ResidualBudget& budget);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_BUDGET_SECTION_H
