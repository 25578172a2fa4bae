#include "report/budget_json.h"

#include <string>

#include "evaluation/budget_verdict.h"

namespace raygrid {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson ShareJson(ErrorCause cause, const CauseShare& share) {
  OrderedJson json = {{"cause", NameOf(cause)}};
  if (!share.can_be_told) {
    json["untold"] = share.untold;
    return json;
  }
  json["part"] = share.in_turn;
  json["alone"] = share.alone;
  json["chance_mean"] = share.chance_mean;
  json["chance_high"] = share.chance_high;
  json["alike"] = share.is_alike;
  return json;
}

CauseShare ParseShare(const OrderedJson& json) {
  CauseShare share;
  share.can_be_told = !json.contains("untold");
  if (!share.can_be_told) {
    share.untold = json.at("untold").get<std::string>();
    return share;
  }
  share.in_turn = json.at("part").get<double>();
  share.alone = json.at("alone").get<double>();
  share.chance_mean = json.at("chance_mean").get<double>();
  share.chance_high = json.at("chance_high").get<double>();
  share.is_alike = json.at("alike").get<bool>();
  return share;
}

OrderedJson FactsJson(const BudgetFacts& facts) {
  OrderedJson json = {{"model", facts.model},
                      {"cell_px", facts.cell_px},
                      {"cells_chosen", facts.cells_chosen},
                      {"tried_finer", facts.tried_finer},
                      {"points_free", facts.points_free},
                      {"bends_tried", facts.bends_tried},
                      {"central-generic", facts.generic_tried},
                      {"noncentral-generic", facts.noncentral_tried},
                      {"two_cameras", facts.two_cameras}};
  if (!facts.better_model.empty()) json["better_model"] = facts.better_model;
  return json;
}

BudgetFacts ParseFacts(const OrderedJson& json) {
  return {json.at("model").get<std::string>(),
          json.at("cell_px").get<double>(),
          json.at("cells_chosen").get<bool>(),
          json.at("tried_finer").get<bool>(),
          json.at("points_free").get<bool>(),
          json.at("bends_tried").get<bool>(),
          json.at("central-generic").get<bool>(),
          json.at("noncentral-generic").get<bool>(),
          json.value("better_model", ""),
          json.at("two_cameras").get<bool>()};
}

}  // namespace

OrderedJson BudgetJson(const ResidualBudget& budget) {
  const BudgetVerdict verdict = JudgeBudget(budget);
  OrderedJson json = {
      {"limited_by", verdict.limit}, {"sentence", verdict.sentence},
      {"to_do", verdict.advice},     {"features", budget.num_features},
      {"views", budget.num_views},   {"tried", FactsJson(budget.facts)}};
  if (!budget.untold.empty()) {
    json["untold"] = budget.untold;
    return json;
  }
  json["rms_px"] = budget.rms_px;
  json["noise_px"] = {budget.noise_px.x(), budget.noise_px.y()};
  json["noise"] = budget.noise;
  json["large_errors"] = budget.large;
  for (int k = 0; k < kNumErrorCauses; ++k) {
    const auto cause = static_cast<ErrorCause>(k);
    json["causes"].push_back(ShareJson(cause, budget.Of(cause)));
  }
  if (budget.OfViews() > 0)
    json["column_time"] = {{"alone", budget.column_time},
                           {"alike", budget.column_time_is_alike}};
  json["of_views"] = budget.OfViews();
  json["rest"] = budget.rest;
  return json;
}

ResidualBudget ParseBudget(const OrderedJson& json) {
  ResidualBudget budget;
  budget.num_features = json.at("features").get<int>();
  budget.num_views = json.at("views").get<int>();
  budget.facts = ParseFacts(json.at("tried"));
  if (json.contains("untold")) {
    budget.untold = json.at("untold").get<std::string>();
    return budget;
  }
  budget.rms_px = json.at("rms_px").get<double>();
  budget.noise_px = {json.at("noise_px").at(0).get<double>(),
                     json.at("noise_px").at(1).get<double>()};
  budget.noise = json.at("noise").get<double>();
  budget.large = json.at("large_errors").get<double>();
  for (int k = 0; k < kNumErrorCauses; ++k)
    budget.causes[static_cast<size_t>(k)] = ParseShare(json.at("causes").at(k));
  if (json.contains("column_time")) {
    budget.column_time = json.at("column_time").at("alone").get<double>();
    budget.column_time_is_alike =
        json.at("column_time").at("alike").get<bool>();
  }
  budget.rest = json.at("rest").get<double>();
  return budget;
}

}  // namespace raygrid
