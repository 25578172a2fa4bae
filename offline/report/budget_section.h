#ifndef RAYGRID_REPORT_BUDGET_SECTION_H
#define RAYGRID_REPORT_BUDGET_SECTION_H

#include <string>

#include "evaluation/residual_budget.h"

namespace raygrid {

/// "What limits this calibration": a sentence, the one thing to do, a bar of
/// the parts of the squared residuals, and their table.
std::string BudgetSection(const ResidualBudget& budget);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_BUDGET_SECTION_H
