#include "report/result_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "dataset/fixed_operating_point.h"
#include "evaluation/operating_point_change.h"
#include "report/result_fields.h"

namespace raygrid {
namespace {

using Json = nlohmann::ordered_json;

// Returns the camera over its only condition: differences from the centre of
// the range.
Json MakeRangeJson(const OperatingPointCalibration& stack) {
  const OperatingPointModel& cameras = stack.cameras;
  const OperatingRange& range = cameras.ranges()[0];
  Json json = {{"quantity", OperatingParameterName(range.condition)},
               {"low", range.low},
               {"high", range.high},
               {"polynomial_order", cameras.orders()[0]},
               {"samples", Json::array()}};
  const int count = std::max(2, static_cast<int>(stack.deviations.size()));
  for (const OperatingPointChange& change :
       MeasureOperatingPointChanges(cameras, count)) {
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

// Returns the camera over each of its conditions, with the others at the centre
// of their ranges.
Json MakeRangesJson(const OperatingPointCalibration& stack) {
  const size_t count = stack.cameras.ranges().size();
  Json json = Json::array();
  for (size_t r = 0; r < count; ++r)
    json.push_back(
        MakeRangeJson(count == 1 ? stack : SliceOperatingPointModel(stack, r)));
  return json;
}

// Adds the results of one camera, alone or in a rig.
void AddCamera(const CalibrationResult& result, Json* json) {
  FieldWriter fields(json);
  VisitCamera(fields, const_cast<CalibrationResult&>(result));
}

void AddVerdict(const Assessment& assessment, Json* json) {
  (*json)["verdict"] = assessment.word;
  (*json)["reasons"] = assessment.reasons;
}

const char* Status(const RigResult& result) {
  if (result.cameras.front().checkpoint) return "interrupted";
  return result.converged ? "converged" : "not converged";
}

Json MakeRigCameraJson(const RigResult& result, size_t camera) {
  const CalibrationResult& own = result.cameras[camera];
  Json json;
  json["name"] = own.camera.name;
  AddCamera(own, &json);
  if (camera < result.held_out.size() && !result.held_out[camera].empty())
    json["held_out_with_rig_poses"] =
        ComputeErrorMetrics(result.held_out[camera]);
  AddVerdict(own.assessment, &json);
  return json;
}

Json MakeBaselineJson(const RigResult& result, const Baseline& baseline) {
  Json json = {{"cameras",
                {result.cameras[baseline.first].camera.name,
                 result.cameras[baseline.second].camera.name}}};
  WriteFields(baseline, &json);
  return json;
}

// Adds rigid multi-board targets and the evidence for their rigidity.
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
         {"frames", pair.num_frames},
         {"translation_sd_m", pair.deviation_m},
         {"rotation_sd_rad", pair.deviation_rad},
         {"expected_translation_sd_m", pair.expected_m},
         {"expected_rotation_sd_rad", pair.expected_rad}});
  const auto descriptions =
      DescribeRigidTargets(result.rigid_targets, result.board_pairs);
  if (!descriptions.empty()) (*json)["rigid_target_summary"] = descriptions;
}

// Totals over all cameras.
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

// Adds the results of a rig, and of each of its cameras.
void AddRig(const RigResult& result, Json* json) {
  const RigCounts counts = Count(result);
  (*json)["model"] = result.cameras.front().camera.camera->Name();
  (*json)["parameters"] = counts.parameters;
  (*json)["images"] = {{"used", counts.images},
                       {"rejected", RejectedInRig(result)}};
  (*json)["features"] = {{"used", counts.features},
                         {"rejected", counts.rejected_features}};
  (*json)["training"] = ComputeTrainingMetrics(result);
  if (const auto held_out = ComputeHeldOutMetrics(result)) {
    (*json)["held_out"] = *held_out;
    (*json)["held_out"]["method"] =
        (result.cross_validated ? kCrossValidation : kHeldOutImages);
  }
  for (const Baseline& baseline : result.baselines)
    (*json)["baselines"].push_back(MakeBaselineJson(result, baseline));
  for (size_t c = 0; c < result.cameras.size(); ++c)
    (*json)["cameras"].push_back(MakeRigCameraJson(result, c));
}

}  // namespace

void AddGeometry(const CameraModel& camera, Json* json) {
  const Area& area = camera.area();
  (*json)["model"] = camera.Name();
  (*json)["image_size"] = {camera.image_size().width,
                           camera.image_size().height};
  (*json)["area"] = {area.x0, area.y0, area.x1, area.y1};
}

void AddUncertaintySummary(const CameraFile& file, Json* json) {
  const UncertaintySummary summary =
      SummarizeUncertainty(*file.camera, *file.uncertainty);
  (*json)["median_px"] = summary.median_px;
  for (size_t k = 0; k < kShareLimitsPx.size(); ++k)
    (*json)["fraction_below_px"][fmt::format("{:g}", kShareLimitsPx[k])] =
        summary.share_below[k];
  (*json)["valid_limit_px"] = file.uncertainty->max_stddev_px;
  (*json)["valid_fraction"] = summary.valid_share;
}

void AddUncertaintyOverRange(const CameraFile& file, Json* json) {
  if (!file.stack) return;
  const auto everywhere = ComputeMaxUncertainty(file);
  (*json)["over_operating_range"] = {
      {"median_px", everywhere->lattice.MedianPx()},
      {"valid_fraction", ComputeValidShare(*file.camera, everywhere->mask)}};
}

void AddCircleAndRanges(const CameraFile& file, Json* json) {
  if (const auto& circle = file.camera->image_circle())
    (*json)["image_circle"] = {
        {"center_px", {circle->center.x(), circle->center.y()}},
        {"radius_px", circle->radii_px.x()}};
  if (file.stack) (*json)["operating_ranges"] = MakeRangesJson(*file.stack);
}

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
      (result.IsRig() ? json["cameras"][c] : json)["packing"] = *packing[c];
  if (stereo) json["rectified_pair"] = *stereo;
  json["stage_seconds"] = result.seconds;
  json["peak_memory_bytes"] = peak_memory_bytes;
  json["seed"] = seed;
  AddVerdict(result.assessment, &json);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace raygrid
