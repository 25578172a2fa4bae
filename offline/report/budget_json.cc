#include "report/budget_json.h"

#include <string>

#include "evaluation/budget_assessment.h"

namespace raygrid {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson ShareJson(ErrorCause cause, const CauseShare& share) {
  OrderedJson json = {{"cause", ToString(cause)}};
  if (!share.is_observable) {
    json["not_observable"] = share.unobservable_reason;
    return json;
  }
  json["fraction"] = share.in_turn;
  json["fraction_alone"] = share.alone;
  json["chance_mean"] = share.chance_mean;
  json["chance_upper_bound"] = share.chance_high;
  json["indistinguishable"] = share.is_indistinguishable;
  return json;
}

CauseShare ParseShare(const OrderedJson& json) {
  CauseShare share;
  share.is_observable = !json.contains("not_observable");
  if (!share.is_observable) {
    share.unobservable_reason = json.at("not_observable").get<std::string>();
    return share;
  }
  share.in_turn = json.at("fraction").get<double>();
  share.alone = json.at("fraction_alone").get<double>();
  share.chance_mean = json.at("chance_mean").get<double>();
  share.chance_high = json.at("chance_upper_bound").get<double>();
  share.is_indistinguishable = json.at("indistinguishable").get<bool>();
  return share;
}

OrderedJson FactsJson(const BudgetFacts& facts) {
  OrderedJson json = {{"model", facts.model},
                      {"knot_spacing_px", facts.knot_spacing_px},
                      {"knot_spacing_selected", facts.knot_spacing_selected},
                      {"finer_spacing_tested", facts.tried_finer},
                      {"target_geometry_estimated", facts.points_free},
                      {"per_view_deformation_tested", facts.bends_tried},
                      {"central_generic_tested", facts.generic_tried},
                      {"noncentral_generic_tested", facts.noncentral_tried},
                      {"two_cameras_suspected", facts.mixed_cameras}};
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
  const BudgetAssessment assessment = AssessBudget(budget);
  OrderedJson json = {{"limited_by", assessment.limit},
                      {"summary", assessment.sentence},
                      {"recommendation", assessment.advice},
                      {"features", budget.num_features},
                      {"views", budget.num_views},
                      {"tried", FactsJson(budget.facts)}};
  if (!budget.unobservable_reason.empty()) {
    json["not_observable"] = budget.unobservable_reason;
    return json;
  }
  json["rms_px"] = budget.rms_px;
  json["noise_px"] = {budget.noise_px.x(), budget.noise_px.y()};
  json["noise_fraction"] = budget.noise;
  json["outlier_fraction"] = budget.large;
  for (int k = 0; k < kNumErrorCauses; ++k) {
    const auto cause = static_cast<ErrorCause>(k);
    json["causes"].push_back(ShareJson(cause, budget.Of(cause)));
  }
  if (budget.PerViewShare() > 0)
    json["column_delay"] = {
        {"fraction_alone", budget.column_delay},
        {"indistinguishable", budget.is_column_delay_indistinguishable}};
  json["per_view_fraction"] = budget.PerViewShare();
  json["unexplained_fraction"] = budget.rest;
  return json;
}

ResidualBudget ParseBudget(const OrderedJson& json) {
  ResidualBudget budget;
  budget.num_features = json.at("features").get<int>();
  budget.num_views = json.at("views").get<int>();
  budget.facts = ParseFacts(json.at("tried"));
  if (json.contains("not_observable")) {
    budget.unobservable_reason = json.at("not_observable").get<std::string>();
    return budget;
  }
  budget.rms_px = json.at("rms_px").get<double>();
  budget.noise_px = {json.at("noise_px").at(0).get<double>(),
                     json.at("noise_px").at(1).get<double>()};
  budget.noise = json.at("noise_fraction").get<double>();
  budget.large = json.at("outlier_fraction").get<double>();
  for (int k = 0; k < kNumErrorCauses; ++k)
    budget.causes[static_cast<size_t>(k)] = ParseShare(json.at("causes").at(k));
  if (json.contains("column_delay")) {
    budget.column_delay =
        json.at("column_delay").at("fraction_alone").get<double>();
    budget.is_column_delay_indistinguishable =
        json.at("column_delay").at("indistinguishable").get<bool>();
  }
  budget.rest = json.at("unexplained_fraction").get<double>();
  return budget;
}

}  // namespace raygrid
