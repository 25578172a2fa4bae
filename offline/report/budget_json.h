#ifndef RAYGRID_REPORT_BUDGET_JSON_H
#define RAYGRID_REPORT_BUDGET_JSON_H

#include <nlohmann/json.hpp>

#include "evaluation/residual_budget.h"

namespace raygrid {

/// Formats "residual_budget" of result.json: fractions of the sum of squared
/// residuals, and the limiting cause, which ParseBudget() derives again.
nlohmann::ordered_json BudgetJson(const ResidualBudget& budget);
/// Parses a budget. Throws nlohmann::json::exception.
ResidualBudget ParseBudget(const nlohmann::ordered_json& json);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_BUDGET_JSON_H
