#include "report/result_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "dataset/error.h"
#include "dataset/held_stack.h"
#include "dataset/json_error.h"
#include "dataset/text_encoding.h"
#include "evaluation/stack_change.h"
#include "report/budget_json.h"

namespace raygrid {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kResultVersion = 1;

Json FiguresJson(const ErrorFigures& figures) {
  return {{"median_px", figures.median_px},
          {"rms_px", figures.rms_px},
          {"max_px", figures.max_px},
          {"count", figures.count}};
}

Json ViewFiguresJson(const ViewFigures& view) {
  return {{"projection", "pinhole"},
          {"size", {view.size.width, view.size.height}},
          {"K",
           {{view.focal_px.x(), 0.0, view.center_px.x()},
            {0.0, view.focal_px.y(), view.center_px.y()},
            {0.0, 0.0, 1.0}}}};
}

Json PackingJson(const PackingFigures& packing) {
  Json json = Json::object();
  if (packing.blob_bytes > 0)
    json = {{"blob_bytes", packing.blob_bytes},
            {"unproject_error_px", packing.unproject_error_px}};
  if (packing.remap_error_px) json["remap_error_px"] = *packing.remap_error_px;
  if (packing.view) json["view"] = ViewFiguresJson(*packing.view);
  if (!packing.remarks.empty()) json["remarks"] = packing.remarks;
  return json;
}

Json RejectedJson(const std::vector<RejectedImage>& images) {
  Json rejected = Json::array();
  for (const RejectedImage& image : images)
    rejected.push_back({{"image", image.image}, {"reason", image.reason}});
  return rejected;
}

Json ImagesJson(const CalibrationResult& result) {
  Json images = {{"used", result.features.images.size()}};
  for (const SameViews& group : result.same_views)
    images["same_views"].push_back(
        {{"image", group.image}, {"others", group.others}});
  if (!result.held_out_copies.empty())
    images["held_out_copies"] = result.held_out_copies;
  images["rejected"] = RejectedJson(result.rejected_images);
  return images;
}

const char* HeldOutBy(bool cross_validated) {
  return cross_validated ? "cross-validation" : "images held out";
}

Json ModelJson(const ModelFigures& figures) {
  Json json = {{"model", figures.model},
               {"parameters", figures.num_parameters},
               {"training", FiguresJson(figures.training)}};
  if (figures.held_out) json["held_out"] = FiguresJson(*figures.held_out);
  if (figures.held_out_flexed)
    json["held_out_flexed"] = FiguresJson(*figures.held_out_flexed);
  if (figures.bias_kl) json["bias_kl"] = *figures.bias_kl;
  return json;
}

Json RowTimeJson(const RowTimeEstimate& row_time) {
  Json json;
  if (row_time.IsTold()) {
    json["row_time_us"] = row_time.value.seconds * 1e6;
    json["deviation_us"] = row_time.value.deviation_s * 1e6;
  } else {
    json["untold"] = row_time.untold;
    if (!row_time.do_times_fit) json["times_fit"] = false;
  }
  json["images"] = row_time.num_images;
  json["taken_out"] = row_time.is_taken_out;
  if (row_time.num_left_out > 0) json["left_out"] = row_time.num_left_out;
  return json;
}

Json BendsJson(const BoardBends& bends) {
  Json views = Json::array(), heights = Json::array();
  for (const BoardBends::View& view : bends.views)
    views.push_back({{"image", view.image},
                     {"board", view.board},
                     {"rms_mm", 1e3 * view.rms_m}});
  for (const double height_m : bends.heights_m)
    heights.push_back(1e3 * height_m);
  return {{"rms_mm", 1e3 * bends.rms_m},
          {"views", views},
          {"most_bent", bends.most_bent},
          {"most_bent_heights_mm", heights}};
}

BoardBends ParseBends(const Json& json) {
  BoardBends bends;
  bends.rms_m = 1e-3 * json.at("rms_mm").get<double>();
  for (const Json& view : json.at("views"))
    bends.views.push_back({view.at("image").get<std::string>(),
                           view.at("board").get<int>(),
                           1e-3 * view.at("rms_mm").get<double>()});
  bends.most_bent = json.at("most_bent").get<int>();
  if (bends.most_bent < 0 ||
      bends.most_bent >= static_cast<int>(bends.views.size()))
    throw InputError("board_bends: most_bent is no view");
  for (const Json& height : json.at("most_bent_heights_mm"))
    bends.heights_m.push_back(1e-3 * height.get<double>());
  return bends;
}

// The camera over its only range: how the image differs from that in the
// middle.
Json RangeJson(const StackOfCameras& stack) {
  const CameraStack& cameras = stack.cameras;
  const ConditionRange& range = cameras.ranges()[0];
  Json json = {{"condition", ConditionName(range.condition)},
               {"low", range.low},
               {"high", range.high},
               {"order", cameras.orders()[0]},
               {"changes", Json::array()}};
  const int count = std::max(2, static_cast<int>(stack.deviations.size()));
  for (const StackChange& change : MeasureStackChanges(cameras, count)) {
    json["changes"].push_back(
        {{"at", change.value},
         {"focal_px", change.focal_px},
         {"growth", change.growth},
         {"center_px", {change.center_px.x(), change.center_px.y()}},
         {"distortion_px", change.distortion_px}});
    const size_t k = json["changes"].size() - 1;
    if (k < stack.deviations.size())
      json["changes"].back()["median_deviation_px"] =
          stack.deviations[k].lattice.MedianPx();
  }
  return json;
}

// Adds "range", or of several conditions "ranges", each with the others in the
// middle.
void AddRanges(const StackOfCameras& stack, Json* json) {
  const size_t count = stack.cameras.ranges().size();
  if (count == 1) {
    (*json)["range"] = RangeJson(stack);
    return;
  }
  for (size_t r = 0; r < count; ++r)
    (*json)["ranges"].push_back(RangeJson(StackAlong(stack, r)));
}

// Adds what is known of one camera, alone or in a rig.
void AddCamera(const CalibrationResult& result, Json* json) {
  const CameraModel& camera = *result.camera.camera;
  (*json)["model"] = camera.Name();
  (*json)["image_size"] = {camera.image_size().width,
                           camera.image_size().height};
  const Area& area = camera.area();
  (*json)["area"] = {area.x0, area.y0, area.x1, area.y1};
  (*json)["parameters"] = result.num_parameters;
  if (result.cell_px > 0) (*json)["cell_px"] = result.cell_px;
  (*json)["images"] = ImagesJson(result);
  Json features = {{"used", result.features.num_features()},
                   {"rejected", result.rejected_features.size()}};
  if (const size_t count = NumWithoutError(result))
    features["used_without_error"] = count;
  if (result.measured_again_rms_px)
    features["measured_again_rms_px"] = *result.measured_again_rms_px;
  (*json)["features"] = features;
  (*json)["training"] = FiguresJson(*result.camera.training);
  if (result.camera.held_out) {
    (*json)["held_out"] = FiguresJson(*result.camera.held_out);
    (*json)["held_out"]["by"] = HeldOutBy(result.cross_validated);
  }
  if (result.held_out_flexed)
    (*json)["held_out_flexed"] = FiguresJson(*result.held_out_flexed);
  if (result.bends) (*json)["board_bends"] = BendsJson(*result.bends);
  for (const CellCandidate& candidate : result.cell_candidates)
    (*json)["cell_candidates"].push_back({{"cell_px", candidate.cell_px},
                                          {"held_out_loss", candidate.loss},
                                          {"median_px", candidate.median_px}});
  if (result.bias_kl) (*json)["bias_kl"] = *result.bias_kl;
  if (result.noise_bias_kl) (*json)["noise_bias_kl"] = *result.noise_bias_kl;
  for (const ModelCandidate& candidate : result.model_candidates)
    (*json)["model_candidates"].push_back(
        {{"model", candidate.model},
         {"cross_validated_loss", candidate.loss},
         {"median_px", candidate.median_px},
         {"gain_standard_errors", candidate.gain}});
  for (const ModelFigures& other : result.parametric_models)
    (*json)["parametric_models"].push_back(ModelJson(other));
  if (result.model_error_px) (*json)["model_error_px"] = *result.model_error_px;
  if (result.neighbor_correlation)
    (*json)["neighbor_correlation"] = *result.neighbor_correlation;
  if (const auto& known = result.camera.uncertainty)
    (*json)["uncertainty"] = {
        {"median_px", known->lattice.MedianPx()},
        {"max_trusted_px", known->max_deviation_px},
        {"trusted_part", known->TrustedPart(camera.image_size(), area)},
        {"jackknife_scale", result.jackknife_scale}};
  if (result.camera.stack && result.camera.uncertainty) {
    const auto everywhere = UncertaintyOverRanges(result.camera);
    (*json)["uncertainty"]["median_over_range_px"] =
        everywhere->lattice.MedianPx();
    (*json)["uncertainty"]["trusted_part_over_range"] =
        everywhere->TrustedPart(camera.image_size(), area);
  }
  if (const auto& circle = camera.image_circle())
    (*json)["image_circle"] = {
        {"center_px", {circle->center.x(), circle->center.y()}},
        {"radius_px", circle->radii_px.x()}};
  if (result.camera.stack) AddRanges(*result.camera.stack, json);
  if (result.budget) (*json)["residual_budget"] = BudgetJson(*result.budget);
  (*json)["fold_over"] = {{"part", result.fold_over.part},
                          {"trusted_part", result.fold_over.trusted_part}};
  if (const auto& distance = result.fleet_distance) {
    Json& json_of = (*json)["fleet_distance"];
    json_of = {{"rms_px", distance->rms_px}, {"units_px", distance->units_px}};
    if (distance->IsStranger()) json_of["warning"] = distance->Warning();
  }
  if (result.row_time) (*json)["row_time"] = RowTimeJson(*result.row_time);
  if (result.line_spread)
    (*json)["line_spread"] = {{"rms_m", result.line_spread->rms_m},
                              {"max_m", result.line_spread->max_m}};
}

void AddVerdict(const Verdict& verdict, Json* json) {
  (*json)["verdict"] = verdict.word;
  (*json)["reasons"] = verdict.reasons;
}

const char* Status(const RigResult& result) {
  if (result.cameras.front().checkpoint) return "interrupted";
  return result.converged ? "converged" : "not converged";
}

Json CameraOfRig(const RigResult& result, size_t camera) {
  const CalibrationResult& own = result.cameras[camera];
  Json json;
  json["name"] = own.camera.name;
  AddCamera(own, &json);
  if (camera < result.held_out.size() && !result.held_out[camera].empty())
    json["held_out_in_rig"] =
        FiguresJson(ComputeErrorFigures(result.held_out[camera]));
  AddVerdict(own.verdict, &json);
  return json;
}

Json BaselineJson(const RigResult& result, const Baseline& baseline) {
  Json json = {{"cameras",
                {result.cameras[baseline.first].camera.name,
                 result.cameras[baseline.second].camera.name}},
               {"common_views", baseline.num_shared_views},
               {"distance_m", baseline.distance_m}};
  if (baseline.distance_sd_m) json["distance_sd_m"] = *baseline.distance_sd_m;
  json["angle_rad"] = baseline.angle_rad;
  if (baseline.rotation_sd_rad)
    json["rotation_sd_rad"] = *baseline.rotation_sd_rad;
  return json;
}

// Adds which boards are fixed to each other, and what tells it.
void AddBodies(const RigResult& result, Json* json) {
  for (const BoardBody& body : result.bodies) {
    Json poses = Json::array();
    for (const Pose& pose : body.first_from_board) {
      const Eigen::Quaterniond& q = pose.rotation;
      const Eigen::Vector3d& t = pose.translation;
      poses.push_back({{"rotation_wxyz", {q.w(), q.x(), q.y(), q.z()}},
                       {"translation_m", {t.x(), t.y(), t.z()}}});
    }
    (*json)["board_bodies"].push_back(
        {{"boards", body.boards}, {"first_from_board", poses}});
  }
  for (const BoardPair& pair : result.board_pairs)
    (*json)["board_pairs"].push_back(
        {{"boards", {pair.first, pair.second}},
         {"fixed", pair.fixed},
         {"instants", pair.num_instants},
         {"deviation_mm", 1e3 * pair.deviation_m},
         {"deviation_degrees", 180 / M_PI * pair.deviation_rad},
         {"expected_mm", 1e3 * pair.expected_m},
         {"expected_degrees", 180 / M_PI * pair.expected_rad}});
  const auto told = BodySentences(result.bodies, result.board_pairs);
  if (!told.empty()) (*json)["boards_told"] = told;
}

// Sums over the cameras.
struct RigCounts {
  size_t parameters = 0, images = 0, features = 0, rejected_features = 0;
};
RigCounts Count(const RigResult& result) {
  RigCounts counts;
  for (const CalibrationResult& camera : result.cameras) {
    counts.parameters += camera.num_parameters;
    counts.images += camera.features.images.size();
    counts.features += camera.features.num_features();
    counts.rejected_features += camera.rejected_features.size();
  }
  return counts;
}

Json RejectedInRig(const RigResult& result) {
  Json rejected = Json::array();
  for (const CalibrationResult& camera : result.cameras)
    for (const RejectedImage& image : camera.rejected_images)
      rejected.push_back({{"camera", camera.camera.name},
                          {"image", image.image},
                          {"reason", image.reason}});
  return rejected;
}

Json StereoJson(const StereoFigures& stereo) {
  return {{"left", stereo.left},
          {"right", stereo.right},
          {"orientation", stereo.is_vertical ? "vertical" : "horizontal"},
          {"rms_px", stereo.rms_px},
          {"max_px", stereo.max_px},
          {"count", stereo.num_features},
          {"image", stereo.instant},
          {"disparities", stereo.num_disparities}};
}

// Adds what is known of the cameras of a rig, and each of them.
void AddRig(const RigResult& result, Json* json) {
  const RigCounts counts = Count(result);
  (*json)["model"] = result.cameras.front().camera.camera->Name();
  (*json)["parameters"] = counts.parameters;
  (*json)["images"] = {{"used", counts.images},
                       {"rejected", RejectedInRig(result)}};
  (*json)["features"] = {{"used", counts.features},
                         {"rejected", counts.rejected_features}};
  (*json)["training"] = FiguresJson(TrainingFigures(result));
  if (const auto held_out = HeldOutFigures(result)) {
    (*json)["held_out"] = FiguresJson(*held_out);
    (*json)["held_out"]["by"] = HeldOutBy(result.cross_validated);
  }
  for (const Baseline& baseline : result.baselines)
    (*json)["baselines"].push_back(BaselineJson(result, baseline));
  for (size_t c = 0; c < result.cameras.size(); ++c)
    (*json)["cameras"].push_back(CameraOfRig(result, c));
}

}  // namespace

size_t NumWithoutError(const CalibrationResult& result) {
  return std::max(result.features.num_features(), result.training.size()) -
         result.training.size();
}

std::string FormatResultJson(
    const RigResult& result, uint64_t seed, int64_t peak_memory_bytes,
    const std::vector<std::optional<PackingFigures>>& packing,
    const std::optional<StereoFigures>& stereo) {
  Json json;
  json["raygrid_result"] = kResultVersion;
  json["status"] = Status(result);
  if (result.IsRig())
    AddRig(result, &json);
  else
    AddCamera(result.cameras.front(), &json);
  AddBodies(result, &json);
  for (size_t c = 0; c < packing.size(); ++c)
    if (packing[c])
      (result.IsRig() ? json["cameras"][c] : json)["packing"] =
          PackingJson(*packing[c]);
  if (stereo) json["rectified_pair"] = StereoJson(*stereo);
  json["seconds"] = result.seconds;
  json["peak_memory_bytes"] = peak_memory_bytes;
  json["seed"] = seed;
  AddVerdict(result.verdict, &json);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

// ---- Reading ---------------------------------------------------------------

namespace {

ErrorFigures ParseFigures(const Json& json) {
  return {json.at("median_px").get<double>(), json.at("rms_px").get<double>(),
          json.at("max_px").get<double>(), json.at("count").get<int>()};
}

std::optional<ErrorFigures> FiguresIfAny(const Json& json, const char* key) {
  if (!json.contains(key)) return std::nullopt;
  return ParseFigures(json.at(key));
}

std::optional<double> NumberIfAny(const Json& json, const char* key) {
  if (!json.contains(key)) return std::nullopt;
  return json.at(key).get<double>();
}

RowTimeEstimate ParseRowTime(const Json& json) {
  RowTimeEstimate row_time;
  row_time.num_images = json.at("images").get<int>();
  row_time.is_taken_out = json.at("taken_out").get<bool>();
  row_time.num_left_out = json.value("left_out", 0);
  row_time.value = {NumberIfAny(json, "row_time_us").value_or(0) * 1e-6,
                    NumberIfAny(json, "deviation_us").value_or(0) * 1e-6};
  if (json.contains("untold"))
    row_time.untold = json.at("untold").get<std::string>();
  row_time.do_times_fit = json.value("times_fit", true);
  return row_time;
}

ModelFigures ParseModel(const Json& json) {
  return {json.at("model").get<std::string>(),
          json.at("parameters").get<int>(),
          ParseFigures(json.at("training")),
          FiguresIfAny(json, "held_out"),
          FiguresIfAny(json, "held_out_flexed"),
          NumberIfAny(json, "bias_kl"),
          {}};
}

void ParseMore(const Json& json, CalibrationResult* result) {
  if (json.contains("cell_candidates"))
    for (const Json& candidate : json.at("cell_candidates"))
      result->cell_candidates.push_back(
          {candidate.at("cell_px").get<double>(),
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
    result->jackknife_scale =
        json.at("uncertainty").value("jackknife_scale", 1.0);
  if (json.contains("line_spread")) {
    LineSpread& spread = result->line_spread.emplace();
    spread.rms_m = json.at("line_spread").at("rms_m").get<double>();
    spread.max_m = json.at("line_spread").at("max_m").get<double>();
  }
  if (json.contains("fleet_distance")) {
    const Json& distance = json.at("fleet_distance");
    result->fleet_distance = {distance.at("rms_px").get<double>(),
                              distance.at("units_px").get<double>()};
  }
}

ViewFigures ParseViewFigures(const Json& json) {
  const auto size = json.at("size").get<std::vector<int>>();
  const auto rows = json.at("K").get<std::vector<std::vector<double>>>();
  ViewFigures view;
  view.size = {size.at(0), size.at(1)};
  view.focal_px = {rows.at(0).at(0), rows.at(1).at(1)};
  view.center_px = {rows.at(0).at(2), rows.at(1).at(2)};
  return view;
}

PackingFigures ParsePacking(const Json& json) {
  PackingFigures packing;
  if (json.contains("blob_bytes")) {
    packing.blob_bytes = json.at("blob_bytes").get<size_t>();
    packing.unproject_error_px = json.at("unproject_error_px").get<double>();
  }
  packing.remap_error_px = NumberIfAny(json, "remap_error_px");
  if (json.contains("view")) packing.view = ParseViewFigures(json.at("view"));
  if (json.contains("remarks"))
    packing.remarks = json.at("remarks").get<std::vector<std::string>>();
  return packing;
}

// Parses the figures of one camera, alone or in a rig.
CalibrationResult ParseCamera(const Json& json) {
  CalibrationResult result;
  if (json.contains("name"))
    result.camera.name = json.at("name").get<std::string>();
  result.num_parameters = json.at("parameters").get<int>();
  result.cell_px = NumberIfAny(json, "cell_px").value_or(0);
  for (const Json& image : json.at("images").at("rejected"))
    result.rejected_images.push_back({image.at("image").get<std::string>(),
                                      image.at("reason").get<std::string>()});
  if (json.at("images").contains("same_views"))
    for (const Json& group : json.at("images").at("same_views"))
      result.same_views.push_back(
          {group.at("image").get<std::string>(),
           group.at("others").get<std::vector<std::string>>()});
  if (json.at("images").contains("held_out_copies"))
    result.held_out_copies =
        json.at("images").at("held_out_copies").get<std::vector<std::string>>();
  result.measured_again_rms_px =
      NumberIfAny(json.at("features"), "measured_again_rms_px");
  result.camera.training = ParseFigures(json.at("training"));
  result.camera.held_out = FiguresIfAny(json, "held_out");
  result.held_out_flexed = FiguresIfAny(json, "held_out_flexed");
  if (json.contains("board_bends"))
    result.bends = ParseBends(json.at("board_bends"));
  if (json.contains("row_time"))
    result.row_time = ParseRowTime(json.at("row_time"));
  result.cross_validated =
      json.contains("held_out") &&
      json.at("held_out").at("by").get<std::string>() == HeldOutBy(true);
  result.bias_kl = NumberIfAny(json, "bias_kl");
  result.noise_bias_kl = NumberIfAny(json, "noise_bias_kl");
  result.neighbor_correlation = NumberIfAny(json, "neighbor_correlation");
  ParseMore(json, &result);
  result.verdict = {json.at("verdict").get<std::string>(),
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

StereoFigures ParseStereo(const Json& json) {
  StereoFigures stereo;
  stereo.left = json.at("left").get<std::string>();
  stereo.right = json.at("right").get<std::string>();
  stereo.is_vertical = json.at("orientation").get<std::string>() == "vertical";
  stereo.rms_px = json.at("rms_px").get<double>();
  stereo.max_px = json.at("max_px").get<double>();
  stereo.num_features = json.at("count").get<int>();
  stereo.instant = json.at("image").get<std::string>();
  stereo.num_disparities = json.at("disparities").get<int>();
  return stereo;
}

Json ParseVersioned(const std::string& path, const std::string& text) {
  RequireSmallTree(path, text);
  const Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded() || !json.is_object())
    throw InputError(path + ": not JSON; calibrate again");
  if (!json.contains("raygrid_result") ||
      json.at("raygrid_result") != kResultVersion)
    throw InputError(fmt::format(
        "{}: written by another version of raygrid (no \"raygrid_result\": "
        "{}); calibrate again with this one",
        path, kResultVersion));
  return json;
}

ResultFigures ParseResult(const Json& json) {
  ResultFigures figures;
  RigResult& result = figures.result;
  const Json cameras =
      json.contains("cameras") ? json.at("cameras") : Json::array({json});
  for (const Json& camera : cameras) {
    result.cameras.push_back(ParseCamera(camera));
    result.cross_validated |= result.cameras.back().cross_validated;
    std::optional<PackingFigures>& packing = figures.packing.emplace_back();
    if (camera.contains("packing")) packing = ParsePacking(camera["packing"]);
  }
  if (json.contains("baselines"))
    for (const Json& baseline : json.at("baselines"))
      result.baselines.push_back(ParseBaseline(baseline, result));
  if (json.contains("boards_told"))
    figures.boards_told =
        json.at("boards_told").get<std::vector<std::string>>();
  if (json.contains("rectified_pair"))
    figures.stereo = ParseStereo(json.at("rectified_pair"));
  result.verdict = {json.at("verdict").get<std::string>(),
                    json.at("reasons").get<std::vector<std::string>>()};
  return figures;
}

}  // namespace

ResultFigures ParseResultJson(const std::string& path,
                              const std::string& text) {
  const Json json = ParseVersioned(path, text);
  try {
    ResultFigures figures = ParseResult(json);
    if (!figures.result.cameras.empty()) return figures;
    throw InputError(path + ": holds no camera; calibrate again");
  } catch (const nlohmann::json::exception& error) {
    throw InputError(
        fmt::format("{}: {}; calibrate again", path, JsonProblem(error)));
  }
}

}  // namespace raygrid
