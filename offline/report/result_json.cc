#include "report/result_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "dataset/held_stack.h"
#include "evaluation/stack_change.h"
#include "report/budget_json.h"
#include "report/result_keys.h"

namespace raygrid {
namespace {

using Json = nlohmann::ordered_json;

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
  if (!packing.remarks.empty()) json["warnings"] = packing.remarks;
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
    images["near_duplicates"].push_back(
        {{"image", group.image}, {"duplicates", group.others}});
  if (!result.held_out_copies.empty())
    images["held_out_duplicates"] = result.held_out_copies;
  images["rejected"] = RejectedJson(result.rejected_images);
  return images;
}

Json ModelJson(const ModelFigures& figures) {
  Json json = {{"model", figures.model},
               {"parameters", figures.num_parameters},
               {"training", FiguresJson(figures.training)}};
  if (figures.held_out) json["held_out"] = FiguresJson(*figures.held_out);
  if (figures.held_out_flexed)
    json["held_out_deformed"] = FiguresJson(*figures.held_out_flexed);
  if (figures.bias_kl) json["bias_kl"] = *figures.bias_kl;
  return json;
}

Json RowTimeJson(const RowTimeEstimate& row_time) {
  Json json;
  if (row_time.IsTold()) {
    json["value_us"] = row_time.value.seconds * 1e6;
    json["sd_us"] = row_time.value.deviation_s * 1e6;
  } else {
    json["not_observable"] = row_time.untold;
    if (!row_time.do_times_fit) json["timestamps_consistent"] = false;
  }
  json["images"] = row_time.num_images;
  json["compensated"] = row_time.is_taken_out;
  if (row_time.num_left_out > 0)
    json["uncompensated_images"] = row_time.num_left_out;
  return json;
}

Json BendsJson(const BoardBends& bends) {
  Json views = Json::array();
  for (const BoardBends::View& view : bends.views)
    views.push_back(
        {{"image", view.image}, {"board", view.board}, {"rms_m", view.rms_m}});
  return {{"rms_m", bends.rms_m},
          {"views", views},
          {"largest_view", bends.most_bent},
          {"largest_view_heights_m", bends.heights_m}};
}

// The camera over its only condition: differences from the middle.
Json RangeJson(const StackOfCameras& stack) {
  const CameraStack& cameras = stack.cameras;
  const ConditionRange& range = cameras.ranges()[0];
  Json json = {{"quantity", ConditionName(range.condition)},
               {"low", range.low},
               {"high", range.high},
               {"polynomial_order", cameras.orders()[0]},
               {"samples", Json::array()}};
  const int count = std::max(2, static_cast<int>(stack.deviations.size()));
  for (const StackChange& change : MeasureStackChanges(cameras, count)) {
    json["samples"].push_back(
        {{"value", change.value},
         {"focal_px", change.focal_px},
         {"scale_change", change.growth},
         {"center_px", {change.center_px.x(), change.center_px.y()}},
         {"distortion_px", change.distortion_px}});
    const size_t k = json["samples"].size() - 1;
    if (k < stack.deviations.size())
      json["samples"].back()["median_uncertainty_px"] =
          stack.deviations[k].lattice.MedianPx();
  }
  return json;
}

// The camera over each of its conditions, with the others at mid-range.
Json RangesJson(const StackOfCameras& stack) {
  const size_t count = stack.cameras.ranges().size();
  Json json = Json::array();
  for (size_t r = 0; r < count; ++r)
    json.push_back(RangeJson(count == 1 ? stack : StackAlong(stack, r)));
  return json;
}

std::string LimitText(double px) { return fmt::format("{:g}", px); }

Json UncertaintyJson(const CalibrationResult& result) {
  const CameraModel& camera = *result.camera.camera;
  const CameraUncertainty& uncertainty = *result.camera.uncertainty;
  const UncertaintySummary summary = SummarizeUncertainty(camera, uncertainty);
  Json json = {{"median_px", summary.median_px}};
  for (size_t k = 0; k < kShareLimitsPx.size(); ++k)
    json["share_below_px"][LimitText(kShareLimitsPx[k])] =
        summary.share_below[k];
  json["valid_limit_px"] = uncertainty.max_deviation_px;
  json["valid_share"] = summary.valid_share;
  if (const auto& region = result.extrapolated) {
    json["extrapolated"] = {{"share", region->share}};
    if (region->share > 0) {
      json["extrapolated"]["p95_px"] = region->p95_px;
      json["extrapolated"]["where"] = region->where;
    }
  }
  json["jackknife_scale"] = result.jackknife_scale;
  if (!result.camera.stack) return json;
  const auto everywhere = UncertaintyOverRanges(result.camera);
  json["over_operating_range"] = {
      {"median_px", everywhere->lattice.MedianPx()},
      {"valid_share", ValidShare(camera, everywhere->mask)}};
  return json;
}

// Adds the results of one camera, alone or in a rig.
void AddCamera(const CalibrationResult& result, Json* json) {
  const CameraModel& camera = *result.camera.camera;
  (*json)["model"] = camera.Name();
  (*json)["image_size"] = {camera.image_size().width,
                           camera.image_size().height};
  const Area& area = camera.area();
  (*json)["area"] = {area.x0, area.y0, area.x1, area.y1};
  (*json)["parameters"] = result.num_parameters;
  if (result.cell_px > 0) (*json)["knot_spacing_px"] = result.cell_px;
  (*json)["images"] = ImagesJson(result);
  Json features = {{"used", result.features.num_features()},
                   {"rejected", result.rejected_features.size()}};
  if (const size_t count = NumWithoutError(result))
    features["used_without_residual"] = count;
  if (result.measured_again_rms_px)
    features["refinement_shift_rms_px"] = *result.measured_again_rms_px;
  (*json)["features"] = features;
  (*json)["training"] = FiguresJson(*result.camera.training);
  if (result.camera.held_out) {
    (*json)["held_out"] = FiguresJson(*result.camera.held_out);
    (*json)["held_out"]["method"] =
        (result.cross_validated ? kCrossValidation : kHeldOutImages);
  }
  if (result.held_out_flexed)
    (*json)["held_out_deformed"] = FiguresJson(*result.held_out_flexed);
  if (result.bends) (*json)["target_deformation"] = BendsJson(*result.bends);
  for (const CellCandidate& candidate : result.cell_candidates)
    (*json)["knot_spacing_candidates"].push_back(
        {{"knot_spacing_px", candidate.cell_px},
         {"held_out_loss", candidate.loss},
         {"median_px", candidate.median_px}});
  if (result.bias_kl) (*json)["bias_kl"] = *result.bias_kl;
  if (result.noise_bias_kl)
    (*json)["bias_kl_white_noise"] = *result.noise_bias_kl;
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
    (*json)["residual_autocorrelation"] = *result.neighbor_correlation;
  if (result.camera.uncertainty)
    (*json)["uncertainty"] = UncertaintyJson(result);
  if (const auto& circle = camera.image_circle())
    (*json)["image_circle"] = {
        {"center_px", {circle->center.x(), circle->center.y()}},
        {"radius_px", circle->radii_px.x()}};
  if (result.camera.stack)
    (*json)["operating_ranges"] = RangesJson(*result.camera.stack);
  if (result.budget) (*json)["residual_budget"] = BudgetJson(*result.budget);
  (*json)["non_injective"] = {{"share", result.fold_over.part},
                              {"valid_share", result.fold_over.trusted_part}};
  if (const auto& distance = result.fleet_distance) {
    Json& json_of = (*json)["population_distance"];
    json_of = {{"rms_px", distance->rms_px},
               {"population_px", distance->units_px}};
    if (distance->IsStranger()) json_of["warning"] = distance->Warning();
  }
  if (result.row_time) (*json)["line_delay"] = RowTimeJson(*result.row_time);
  if (result.line_spread)
    (*json)["noncentrality"] = {{"rms_m", result.line_spread->rms_m},
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

// Adds rigid multi-board targets, and the evidence for them.
void AddBodies(const RigResult& result, Json* json) {
  for (const BoardBody& body : result.bodies) {
    Json poses = Json::array();
    for (const Pose& pose : body.first_from_board) {
      const Eigen::Quaterniond& q = pose.rotation;
      const Eigen::Vector3d& t = pose.translation;
      poses.push_back({{"rotation_wxyz", {q.w(), q.x(), q.y(), q.z()}},
                       {"translation_m", {t.x(), t.y(), t.z()}}});
    }
    (*json)["rigid_targets"].push_back(
        {{"boards", body.boards}, {"first_from_board", poses}});
  }
  for (const BoardPair& pair : result.board_pairs)
    (*json)["board_pairs"].push_back(
        {{"boards", {pair.first, pair.second}},
         {"rigid", pair.fixed},
         {"frames", pair.num_instants},
         {"translation_sd_m", pair.deviation_m},
         {"rotation_sd_rad", pair.deviation_rad},
         {"expected_translation_sd_m", pair.expected_m},
         {"expected_rotation_sd_rad", pair.expected_rad}});
  const auto told = BodySentences(result.bodies, result.board_pairs);
  if (!told.empty()) (*json)["rigid_target_summary"] = told;
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

// Adds the results of a rig, and of each of its cameras.
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
    (*json)["held_out"]["method"] =
        (result.cross_validated ? kCrossValidation : kHeldOutImages);
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
  json["schema_version"] = kResultSchemaVersion;
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

}  // namespace raygrid
