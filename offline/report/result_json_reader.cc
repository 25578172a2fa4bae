#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "dataset/error.h"
#include "dataset/json_error.h"
#include "dataset/text_encoding.h"
#include "report/budget_json.h"
#include "report/result_json.h"
#include "report/result_keys.h"

namespace raygrid {
namespace {

using Json = nlohmann::ordered_json;

ErrorMetrics ParseMetrics(const Json& json) {
  return {json.at("median_px").get<double>(), json.at("rms_px").get<double>(),
          json.at("max_px").get<double>(), json.at("count").get<int>()};
}

std::optional<ErrorMetrics> MetricsIfAny(const Json& json, const char* key) {
  if (!json.contains(key)) return std::nullopt;
  return ParseMetrics(json.at(key));
}

std::optional<double> NumberIfAny(const Json& json, const char* key) {
  if (!json.contains(key)) return std::nullopt;
  return json.at(key).get<double>();
}

LineDelayEstimate ParseLineDelay(const Json& json) {
  LineDelayEstimate line_delay;
  line_delay.num_images = json.at("images").get<int>();
  line_delay.is_compensated = json.at("compensated").get<bool>();
  line_delay.num_left_out = json.value("uncompensated_images", 0);
  line_delay.value = {NumberIfAny(json, "value_us").value_or(0) * 1e-6,
                      NumberIfAny(json, "sd_us").value_or(0) * 1e-6};
  if (json.contains("not_observable"))
    line_delay.unobservable_reason =
        json.at("not_observable").get<std::string>();
  line_delay.are_timestamps_consistent =
      json.value("timestamps_consistent", true);
  return line_delay;
}

BoardDeformation ParseBends(const Json& json) {
  BoardDeformation bends;
  bends.rms_m = json.at("rms_m").get<double>();
  for (const Json& view : json.at("views"))
    bends.views.push_back({view.at("image").get<std::string>(),
                           view.at("board").get<int>(),
                           view.at("rms_m").get<double>()});
  bends.most_deformed = json.at("largest_view").get<int>();
  if (bends.most_deformed < 0 ||
      bends.most_deformed >= static_cast<int>(bends.views.size()))
    throw InputError(
        "target_deformation: largest_view is not the index of a view");
  for (const Json& height : json.at("largest_view_heights_m"))
    bends.heights_m.push_back(height.get<double>());
  return bends;
}

ModelMetrics ParseModel(const Json& json) {
  return {json.at("model").get<std::string>(),
          json.at("parameters").get<int>(),
          ParseMetrics(json.at("training")),
          MetricsIfAny(json, "held_out"),
          MetricsIfAny(json, "held_out_with_deformation"),
          NumberIfAny(json, "bias_kl"),
          {}};
}

// Parses what the camera file does not contain.
void ParseUncertainty(const Json& json, CalibrationResult* result) {
  result->jackknife_scale = json.value("jackknife_scale", 1.0);
  if (!json.contains("extrapolated")) return;
  const Json& region = json.at("extrapolated");
  result->extrapolated = {region.at("fraction").get<double>(),
                          region.value("p95_px", 0.0),
                          region.value("location", "")};
}

void ParseMore(const Json& json, CalibrationResult* result) {
  if (json.contains("knot_spacing_candidates"))
    for (const Json& candidate : json.at("knot_spacing_candidates"))
      result->knot_spacing_candidates.push_back(
          {candidate.at("knot_spacing_px").get<double>(),
           candidate.at("held_out_loss").get<double>(),
           candidate.at("median_px").get<double>()});
  if (json.contains("model_error_px"))
    result->model_error_px = json.at("model_error_px").get<double>();
  if (json.contains("model_candidates"))
    for (const Json& candidate : json.at("model_candidates"))
      result->model_candidates.push_back(
          {candidate.at("model").get<std::string>(),
           candidate.at("cross_validated_loss").get<double>(),
           candidate.at("median_px").get<double>(),
           candidate.at("gain_standard_errors").get<double>()});
  if (json.contains("parametric_models"))
    for (const Json& other : json.at("parametric_models"))
      result->parametric_models.push_back(ParseModel(other));
  if (json.contains("residual_budget"))
    result->budget = ParseBudget(json.at("residual_budget"));
  if (json.contains("uncertainty"))
    ParseUncertainty(json.at("uncertainty"), result);
  if (json.contains("noncentrality")) {
    LineSpread& spread = result->line_spread.emplace();
    spread.rms_m = json.at("noncentrality").at("rms_m").get<double>();
    spread.max_m = json.at("noncentrality").at("max_m").get<double>();
  }
  if (json.contains("population_distance")) {
    const Json& distance = json.at("population_distance");
    result->fleet_distance = {distance.at("rms_px").get<double>(),
                              distance.at("population_rms_px").get<double>()};
  }
}

ViewMetrics ParseViewMetrics(const Json& json) {
  const auto size = json.at("size").get<std::vector<int>>();
  const auto rows = json.at("K").get<std::vector<std::vector<double>>>();
  ViewMetrics view;
  view.size = {size.at(0), size.at(1)};
  view.focal_px = {rows.at(0).at(0), rows.at(1).at(1)};
  view.center_px = {rows.at(0).at(2), rows.at(1).at(2)};
  return view;
}

PackingMetrics ParsePacking(const Json& json) {
  PackingMetrics packing;
  if (json.contains("blob_bytes")) {
    packing.blob_bytes = json.at("blob_bytes").get<size_t>();
    packing.unproject_error_px = json.at("unproject_error_px").get<double>();
  }
  packing.remap_error_px = NumberIfAny(json, "remap_error_px");
  if (json.contains("view")) packing.view = ParseViewMetrics(json.at("view"));
  if (json.contains("warnings"))
    packing.warnings = json.at("warnings").get<std::vector<std::string>>();
  return packing;
}

// Parses the metrics of one camera, alone or in a rig.
CalibrationResult ParseCamera(const Json& json) {
  CalibrationResult result;
  if (json.contains("name"))
    result.camera.name = json.at("name").get<std::string>();
  result.num_parameters = json.at("parameters").get<int>();
  result.knot_spacing_px = NumberIfAny(json, "knot_spacing_px").value_or(0);
  for (const Json& image : json.at("images").at("rejected"))
    result.rejected_images.push_back({image.at("image").get<std::string>(),
                                      image.at("reason").get<std::string>()});
  if (json.at("images").contains("near_duplicates"))
    for (const Json& group : json.at("images").at("near_duplicates"))
      result.near_duplicates.push_back(
          {group.at("image").get<std::string>(),
           group.at("duplicates").get<std::vector<std::string>>()});
  if (json.at("images").contains("held_out_duplicates"))
    result.held_out_duplicates = json.at("images")
                                     .at("held_out_duplicates")
                                     .get<std::vector<std::string>>();
  result.refinement_rms_px =
      NumberIfAny(json.at("features"), "refinement_shift_rms_px");
  result.camera.training = ParseMetrics(json.at("training"));
  result.camera.held_out = MetricsIfAny(json, "held_out");
  result.held_out_deformed = MetricsIfAny(json, "held_out_with_deformation");
  if (json.contains("target_deformation"))
    result.bends = ParseBends(json.at("target_deformation"));
  if (json.contains("line_delay"))
    result.line_delay = ParseLineDelay(json.at("line_delay"));
  result.cross_validated =
      json.contains("held_out") &&
      json.at("held_out").at("method").get<std::string>() == kCrossValidation;
  result.bias_kl = NumberIfAny(json, "bias_kl");
  result.noise_bias_kl = NumberIfAny(json, "bias_kl_white_noise");
  result.neighbor_correlation = NumberIfAny(json, "residual_autocorrelation");
  ParseMore(json, &result);
  result.assessment = {json.at("verdict").get<std::string>(),
                       json.at("reasons").get<std::vector<std::string>>()};
  return result;
}

Baseline ParseBaseline(const Json& json, const RigResult& rig) {
  const auto index = [&](int k) {
    const std::string name = json.at("cameras").at(k).get<std::string>();
    size_t c = 0;
    while (c < rig.cameras.size() && rig.cameras[c].camera.name != name) ++c;
    if (c == rig.cameras.size())
      throw InputError("baselines name an unknown camera");
    return c;
  };
  Baseline baseline;
  baseline.first = index(0);
  baseline.second = index(1);
  baseline.num_shared_views = json.at("common_views").get<int>();
  baseline.distance_m = json.at("distance_m").get<double>();
  baseline.distance_sd_m = NumberIfAny(json, "distance_sd_m");
  baseline.angle_rad = json.at("angle_rad").get<double>();
  baseline.rotation_sd_rad = NumberIfAny(json, "rotation_sd_rad");
  return baseline;
}

StereoMetrics ParseStereo(const Json& json) {
  StereoMetrics stereo;
  stereo.left = json.at("left").get<std::string>();
  stereo.right = json.at("right").get<std::string>();
  stereo.is_vertical = json.at("orientation").get<std::string>() == "vertical";
  stereo.rms_px = json.at("rms_px").get<double>();
  stereo.max_px = json.at("max_px").get<double>();
  stereo.num_features = json.at("count").get<int>();
  stereo.instant = json.at("image").get<std::string>();
  stereo.num_disparities = json.at("num_disparities").get<int>();
  return stereo;
}

Json ParseVersioned(const std::string& path, const std::string& text) {
  RequireSmallTree(path, text);
  Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded() || !json.is_object())
    throw InputError(path + ": not JSON; calibrate again");
  if (!UpgradeResult(&json))
    throw InputError(fmt::format(
        "{}: written by another version of raygrid (schema_version is not {}); "
        "calibrate again with this one",
        path, kResultSchemaVersion));
  return json;
}

ResultMetrics ParseResult(const Json& json) {
  ResultMetrics metrics;
  RigResult& result = metrics.result;
  const Json cameras =
      json.contains("cameras") ? json.at("cameras") : Json::array({json});
  for (const Json& camera : cameras) {
    result.cameras.push_back(ParseCamera(camera));
    result.cross_validated |= result.cameras.back().cross_validated;
    std::optional<PackingMetrics>& packing = metrics.packing.emplace_back();
    if (camera.contains("packing")) packing = ParsePacking(camera["packing"]);
  }
  if (json.contains("baselines"))
    for (const Json& baseline : json.at("baselines"))
      result.baselines.push_back(ParseBaseline(baseline, result));
  if (json.contains("rigid_target_summary"))
    metrics.rigid_target_summary =
        json.at("rigid_target_summary").get<std::vector<std::string>>();
  if (json.contains("rectified_pair"))
    metrics.stereo = ParseStereo(json.at("rectified_pair"));
  result.assessment = {json.at("verdict").get<std::string>(),
                       json.at("reasons").get<std::vector<std::string>>()};
  return metrics;
}

}  // namespace

ResultMetrics ParseResultJson(const std::string& path,
                              const std::string& text) {
  const Json json = ParseVersioned(path, text);
  try {
    ResultMetrics metrics = ParseResult(json);
    if (!metrics.result.cameras.empty()) return metrics;
    throw InputError(path + ": contains no camera; calibrate again");
  } catch (const nlohmann::json::exception& error) {
    throw InputError(
        fmt::format("{}: {}; calibrate again", path, JsonProblem(error)));
  }
}

}  // namespace raygrid
