#include "report/result_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "dataset/fixed_operating_point.h"
#include "evaluation/stack_change.h"
#include "report/budget_json.h"
#include "report/result_keys.h"

namespace raygrid {
namespace {

using Json = nlohmann::ordered_json;

Json MetricsJson(const ErrorMetrics& metrics) {
  return {{"median_px", metrics.median_px},
          {"rms_px", metrics.rms_px},
          {"max_px", metrics.max_px},
          {"count", metrics.count}};
}

Json ViewMetricsJson(const ViewMetrics& view) {
  return {{"projection", "pinhole"},
          {"size", {view.size.width, view.size.height}},
          {"K",
           {{view.focal_px.x(), 0.0, view.center_px.x()},
            {0.0, view.focal_px.y(), view.center_px.y()},
            {0.0, 0.0, 1.0}}}};
}

Json PackingJson(const PackingMetrics& packing) {
  Json json = Json::object();
  if (packing.blob_bytes > 0)
    json = {{"blob_bytes", packing.blob_bytes},
            {"unproject_error_px", packing.unproject_error_px}};
  if (packing.remap_error_px) json["remap_error_px"] = *packing.remap_error_px;
  if (packing.view) json["view"] = ViewMetricsJson(*packing.view);
  if (!packing.warnings.empty()) json["warnings"] = packing.warnings;
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
  for (const NearDuplicates& group : result.near_duplicates)
    images["near_duplicates"].push_back(
        {{"image", group.image}, {"duplicates", group.others}});
  if (!result.held_out_duplicates.empty())
    images["held_out_duplicates"] = result.held_out_duplicates;
  images["rejected"] = RejectedJson(result.rejected_images);
  return images;
}

Json ModelJson(const ModelMetrics& metrics) {
  Json json = {{"model", metrics.model},
               {"parameters", metrics.num_parameters},
               {"training", MetricsJson(metrics.training)}};
  if (metrics.held_out) json["held_out"] = MetricsJson(*metrics.held_out);
  if (metrics.held_out_deformed)
    json["held_out_with_deformation"] = MetricsJson(*metrics.held_out_deformed);
  if (metrics.bias_kl) json["bias_kl"] = *metrics.bias_kl;
  return json;
}

Json LineDelayJson(const LineDelayEstimate& line_delay) {
  Json json;
  if (line_delay.IsDetermined()) {
    json["value_us"] = line_delay.value.seconds * 1e6;
    json["sd_us"] = line_delay.value.deviation_s * 1e6;
  } else {
    json["not_observable"] = line_delay.unobservable_reason;
    if (!line_delay.are_timestamps_consistent)
      json["timestamps_consistent"] = false;
  }
  json["images"] = line_delay.num_images;
  json["compensated"] = line_delay.is_compensated;
  if (line_delay.num_left_out > 0)
    json["uncompensated_images"] = line_delay.num_left_out;
  return json;
}

Json BendsJson(const BoardDeformation& bends) {
  Json views = Json::array();
  for (const BoardDeformation::View& view : bends.views)
    views.push_back(
        {{"image", view.image}, {"board", view.board}, {"rms_m", view.rms_m}});
  return {{"rms_m", bends.rms_m},
          {"views", views},
          {"largest_view", bends.most_deformed},
          {"largest_view_heights_m", bends.heights_m}};
}

// The camera over its only condition: differences from the middle.
Json RangeJson(const OperatingPointCalibration& stack) {
  const OperatingPointModel& cameras = stack.cameras;
  const OperatingRange& range = cameras.ranges()[0];
  Json json = {{"quantity", OperatingParameterName(range.condition)},
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
Json RangesJson(const OperatingPointCalibration& stack) {
  const size_t count = stack.cameras.ranges().size();
  Json json = Json::array();
  for (size_t r = 0; r < count; ++r)
    json.push_back(
        RangeJson(count == 1 ? stack : SliceOperatingPointModel(stack, r)));
  return json;
}

std::string LimitText(double px) { return fmt::format("{:g}", px); }

Json UncertaintyJson(const CalibrationResult& result) {
  const CameraModel& camera = *result.camera.camera;
  const CameraUncertainty& uncertainty = *result.camera.uncertainty;
  const UncertaintySummary summary = SummarizeUncertainty(camera, uncertainty);
  Json json = {{"median_px", summary.median_px}};
  for (size_t k = 0; k < kShareLimitsPx.size(); ++k)
    json["fraction_below_px"][LimitText(kShareLimitsPx[k])] =
        summary.share_below[k];
  json["valid_limit_px"] = uncertainty.max_deviation_px;
  json["valid_fraction"] = summary.valid_share;
  if (const auto& region = result.extrapolated) {
    json["extrapolated"] = {{"fraction", region->share}};
    if (region->share > 0) {
      json["extrapolated"]["p95_px"] = region->p95_px;
      json["extrapolated"]["location"] = region->where;
    }
  }
  json["jackknife_scale"] = result.jackknife_scale;
  if (!result.camera.stack) return json;
  const auto everywhere = ComputeMaxUncertainty(result.camera);
  json["over_operating_range"] = {
      {"median_px", everywhere->lattice.MedianPx()},
      {"valid_fraction", ComputeValidShare(camera, everywhere->mask)}};
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
  if (result.knot_spacing_px > 0)
    (*json)["knot_spacing_px"] = result.knot_spacing_px;
  (*json)["images"] = ImagesJson(result);
  Json features = {{"used", result.features.num_features()},
                   {"rejected", result.rejected_features.size()}};
  if (const size_t count = CountMissingErrors(result))
    features["used_without_residual"] = count;
  if (result.refinement_rms_px)
    features["refinement_shift_rms_px"] = *result.refinement_rms_px;
  (*json)["features"] = features;
  (*json)["training"] = MetricsJson(*result.camera.training);
  if (result.camera.held_out) {
    (*json)["held_out"] = MetricsJson(*result.camera.held_out);
    (*json)["held_out"]["method"] =
        (result.cross_validated ? kCrossValidation : kHeldOutImages);
  }
  if (result.held_out_deformed)
    (*json)["held_out_with_deformation"] =
        MetricsJson(*result.held_out_deformed);
  if (result.bends) (*json)["target_deformation"] = BendsJson(*result.bends);
  for (const KnotSpacingCandidate& candidate : result.knot_spacing_candidates)
    (*json)["knot_spacing_candidates"].push_back(
        {{"knot_spacing_px", candidate.knot_spacing_px},
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
  for (const ModelMetrics& other : result.parametric_models)
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
  (*json)["non_injective"] = {{"fraction", result.fold_over.part},
                              {"valid_fraction", result.fold_over.valid_part}};
  if (const auto& distance = result.fleet_distance) {
    Json& json_of = (*json)["population_distance"];
    json_of = {{"rms_px", distance->rms_px},
               {"population_rms_px", distance->units_px}};
    if (distance->IsOutlier()) json_of["warning"] = distance->Warning();
  }
  if (result.line_delay)
    (*json)["line_delay"] = LineDelayJson(*result.line_delay);
  if (result.line_spread)
    (*json)["noncentrality"] = {{"rms_m", result.line_spread->rms_m},
                                {"max_m", result.line_spread->max_m}};
}

void AddVerdict(const Assessment& assessment, Json* json) {
  (*json)["verdict"] = assessment.word;
  (*json)["reasons"] = assessment.reasons;
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
    json["held_out_with_rig_poses"] =
        MetricsJson(ComputeErrorMetrics(result.held_out[camera]));
  AddVerdict(own.assessment, &json);
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
void AddRigidTargets(const RigResult& result, Json* json) {
  for (const RigidTarget& body : result.rigid_targets) {
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
  const auto told =
      DescribeRigidTargets(result.rigid_targets, result.board_pairs);
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

Json StereoJson(const StereoMetrics& stereo) {
  return {{"left", stereo.left},
          {"right", stereo.right},
          {"orientation", stereo.is_vertical ? "vertical" : "horizontal"},
          {"rms_px", stereo.rms_px},
          {"max_px", stereo.max_px},
          {"count", stereo.num_features},
          {"image", stereo.instant},
          {"num_disparities", stereo.num_disparities}};
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
  (*json)["training"] = MetricsJson(ComputeTrainingMetrics(result));
  if (const auto held_out = ComputeHeldOutMetrics(result)) {
    (*json)["held_out"] = MetricsJson(*held_out);
    (*json)["held_out"]["method"] =
        (result.cross_validated ? kCrossValidation : kHeldOutImages);
  }
  for (const Baseline& baseline : result.baselines)
    (*json)["baselines"].push_back(BaselineJson(result, baseline));
  for (size_t c = 0; c < result.cameras.size(); ++c)
    (*json)["cameras"].push_back(CameraOfRig(result, c));
}

}  // namespace

size_t CountMissingErrors(const CalibrationResult& result) {
  return std::max(result.features.num_features(), result.training.size()) -
         result.training.size();
}

std::string FormatResultJson(
    const RigResult& result, uint64_t seed, int64_t peak_memory_bytes,
    const std::vector<std::optional<PackingMetrics>>& packing,
    const std::optional<StereoMetrics>& stereo) {
  Json json;
  json["schema_version"] = kResultSchemaVersion;
  json["status"] = Status(result);
  if (result.IsRig())
    AddRig(result, &json);
  else
    AddCamera(result.cameras.front(), &json);
  AddRigidTargets(result, &json);
  for (size_t c = 0; c < packing.size(); ++c)
    if (packing[c])
      (result.IsRig() ? json["cameras"][c] : json)["packing"] =
          PackingJson(*packing[c]);
  if (stereo) json["rectified_pair"] = StereoJson(*stereo);
  json["stage_seconds"] = result.seconds;
  json["peak_memory_bytes"] = peak_memory_bytes;
  json["seed"] = seed;
  AddVerdict(result.assessment, &json);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace raygrid
