#ifndef RAYGRID_REPORT_BUDGET_JSON_H
#define RAYGRID_REPORT_BUDGET_JSON_H

#include <nlohmann/json.hpp>

#include "evaluation/residual_budget.h"

namespace raygrid {

/// "residual_budget" of result.json: parts of the squared residuals, and the
/// verdict on them, which readers form anew.
nlohmann::ordered_json BudgetJson(const ResidualBudget& budget);
/// Throws nlohmann::json::exception.
ResidualBudget ParseBudget(const nlohmann::ordered_json& json);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_BUDGET_JSON_H
