#include "report/budget_json.h"

#include <string>

#include "evaluation/budget_verdict.h"

namespace raygrid {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson ShareJson(ErrorCause cause, const CauseShare& share) {
  OrderedJson json = {{"cause", NameOf(cause)}};
  if (!share.can_be_told) {
    json["not_observable"] = share.untold;
    return json;
  }
  json["share"] = share.in_turn;
  json["share_alone"] = share.alone;
  json["chance_mean"] = share.chance_mean;
  json["chance_upper_bound"] = share.chance_high;
  json["indistinguishable"] = share.is_alike;
  return json;
}

CauseShare ParseShare(const OrderedJson& json) {
  CauseShare share;
  share.can_be_told = !json.contains("not_observable");
  if (!share.can_be_told) {
    share.untold = json.at("not_observable").get<std::string>();
    return share;
  }
  share.in_turn = json.at("share").get<double>();
  share.alone = json.at("share_alone").get<double>();
  share.chance_mean = json.at("chance_mean").get<double>();
  share.chance_high = json.at("chance_upper_bound").get<double>();
  share.is_alike = json.at("indistinguishable").get<bool>();
  return share;
}

OrderedJson FactsJson(const BudgetFacts& facts) {
  OrderedJson json = {{"model", facts.model},
                      {"knot_spacing_px", facts.cell_px},
                      {"knot_spacing_selected", facts.cells_chosen},
                      {"finer_spacing_tested", facts.tried_finer},
                      {"target_geometry_estimated", facts.points_free},
                      {"per_view_deformation_tested", facts.bends_tried},
                      {"central_generic_tested", facts.generic_tried},
                      {"noncentral_generic_tested", facts.noncentral_tried},
                      {"two_cameras_suspected", facts.two_cameras}};
  if (!facts.better_model.empty()) json["better_model"] = facts.better_model;
  return json;
}

BudgetFacts ParseFacts(const OrderedJson& json) {
  return {json.at("model").get<std::string>(),
          json.at("knot_spacing_px").get<double>(),
          json.at("knot_spacing_selected").get<bool>(),
          json.at("finer_spacing_tested").get<bool>(),
          json.at("target_geometry_estimated").get<bool>(),
          json.at("per_view_deformation_tested").get<bool>(),
          json.at("central_generic_tested").get<bool>(),
          json.at("noncentral_generic_tested").get<bool>(),
          json.value("better_model", ""),
          json.at("two_cameras_suspected").get<bool>()};
}

}  // namespace

OrderedJson BudgetJson(const ResidualBudget& budget) {
  const BudgetVerdict verdict = JudgeBudget(budget);
  OrderedJson json = {
      {"limited_by", verdict.limit},      {"summary", verdict.sentence},
      {"recommendation", verdict.advice}, {"features", budget.num_features},
      {"views", budget.num_views},        {"tried", FactsJson(budget.facts)}};
  if (!budget.untold.empty()) {
    json["not_observable"] = budget.untold;
    return json;
  }
  json["rms_px"] = budget.rms_px;
  json["noise_px"] = {budget.noise_px.x(), budget.noise_px.y()};
  json["noise_share"] = budget.noise;
  json["outlier_share"] = budget.large;
  for (int k = 0; k < kNumErrorCauses; ++k) {
    const auto cause = static_cast<ErrorCause>(k);
    json["causes"].push_back(ShareJson(cause, budget.Of(cause)));
  }
  if (budget.OfViews() > 0)
    json["column_delay"] = {{"share_alone", budget.column_time},
                            {"indistinguishable", budget.column_time_is_alike}};
  json["per_view_share"] = budget.OfViews();
  json["unexplained_share"] = budget.rest;
  return json;
}

ResidualBudget ParseBudget(const OrderedJson& json) {
  ResidualBudget budget;
  budget.num_features = json.at("features").get<int>();
  budget.num_views = json.at("views").get<int>();
  budget.facts = ParseFacts(json.at("tried"));
  if (json.contains("not_observable")) {
    budget.untold = json.at("not_observable").get<std::string>();
    return budget;
  }
  budget.rms_px = json.at("rms_px").get<double>();
  budget.noise_px = {json.at("noise_px").at(0).get<double>(),
                     json.at("noise_px").at(1).get<double>()};
  budget.noise = json.at("noise_share").get<double>();
  budget.large = json.at("outlier_share").get<double>();
  for (int k = 0; k < kNumErrorCauses; ++k)
    budget.causes[static_cast<size_t>(k)] = ParseShare(json.at("causes").at(k));
  if (json.contains("column_delay")) {
    budget.column_time =
        json.at("column_delay").at("share_alone").get<double>();
    budget.column_time_is_alike =
        json.at("column_delay").at("indistinguishable").get<bool>();
  }
  budget.rest = json.at("unexplained_share").get<double>();
  return budget;
}

}  // namespace raygrid
