#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "dataset/error.h"
#include "dataset/json_error.h"
#include "dataset/text_encoding.h"
#include "report/result_fields.h"

namespace raygrid {
namespace {

using Json = nlohmann::ordered_json;

Assessment ParseAssessment(const Json& json) {
  return {json.at("verdict").get<std::string>(),
          json.at("reasons").get<std::vector<std::string>>()};
}

// Parses the metrics of one camera, alone or in a rig.
CalibrationResult ParseCamera(const Json& json) {
  CalibrationResult result;
  result.camera.name = json.value("name", "");
  const FieldReader fields(json);
  VisitCamera(fields, result);
  if (result.bends && (result.bends->most_deformed < 0 ||
                       result.bends->most_deformed >=
                           static_cast<int>(result.bends->views.size())))
    throw InputError(
        "target_deformation: largest_view is not the index of a view");
  result.assessment = ParseAssessment(json);
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
  auto baseline = json.get<Baseline>();
  baseline.first = index(0);
  baseline.second = index(1);
  return baseline;
}

Json ParseVersioned(const std::string& path, const std::string& text) {
  RequireSmallTree(path, text);
  Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded() || !json.is_object())
    throw InputError(path + ": not JSON; rerun the calibration");
  if (!UpgradeResult(&json))
    throw InputError(
        fmt::format("{}: written by another version of raygrid (schema_version "
                    "is not {}); rerun the calibration with this version",
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
    const FieldReader fields(camera);
    fields("packing", metrics.packing.emplace_back());
  }
  if (json.contains("baselines"))
    for (const Json& baseline : json.at("baselines"))
      result.baselines.push_back(ParseBaseline(baseline, result));
  const FieldReader fields(json);
  fields.NonEmpty("rigid_target_summary", metrics.rigid_target_summary);
  fields("rectified_pair", metrics.stereo);
  result.assessment = ParseAssessment(json);
  return metrics;
}

}  // namespace

ResultMetrics ParseResultJson(const std::string& path,
                              const std::string& text) {
  const Json json = ParseVersioned(path, text);
  try {
    ResultMetrics metrics = ParseResult(json);
    if (!metrics.result.cameras.empty()) return metrics;
    throw InputError(path + ": contains no camera; rerun the calibration");
  } catch (const nlohmann::json::exception& error) {
    throw InputError(
        fmt::format("{}: {}; rerun the calibration", path, JsonProblem(error)));
  }
}

}  // namespace raygrid
