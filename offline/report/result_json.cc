#include "report/result_json.h"

#include <nlohmann/json.hpp>

namespace raygrid {
namespace {

using Json = nlohmann::ordered_json;

Json FiguresJson(const ErrorFigures& figures) {
  return {{"median_px", figures.median_px},
          {"rms_px", figures.rms_px},
          {"max_px", figures.max_px},
          {"count", figures.count}};
}

Json RejectedJson(const std::vector<RejectedImage>& images) {
  Json rejected = Json::array();
  for (const RejectedImage& image : images)
    rejected.push_back({{"image", image.image}, {"reason", image.reason}});
  return rejected;
}

const char* HeldOutBy(bool cross_validated) {
  return cross_validated ? "cross-validation" : "images held out";
}

// What is known of one camera, alone or in a rig.
void AddCamera(const CalibrationResult& result, Json* json) {
  const CameraModel& camera = *result.camera.camera;
  (*json)["model"] = camera.Name();
  (*json)["image_size"] = {camera.image_size().width,
                           camera.image_size().height};
  const Area& area = camera.area();
  (*json)["area"] = {area.x0, area.y0, area.x1, area.y1};
  (*json)["parameters"] = result.num_parameters;
  if (result.cell_px > 0) (*json)["cell_px"] = result.cell_px;
  (*json)["images"] = {{"used", result.features.images.size()},
                       {"rejected", RejectedJson(result.rejected_images)}};
  Json features = {{"used", result.features.num_features()},
                   {"rejected", result.rejected_features.size()}};
  if (result.measured_again_rms_px)
    features["measured_again_rms_px"] = *result.measured_again_rms_px;
  (*json)["features"] = features;
  (*json)["training"] = FiguresJson(*result.camera.training);
  if (result.camera.held_out) {
    (*json)["held_out"] = FiguresJson(*result.camera.held_out);
    (*json)["held_out"]["by"] = HeldOutBy(result.cross_validated);
  }
  for (const CellCandidate& candidate : result.cell_candidates)
    (*json)["cell_candidates"].push_back({{"cell_px", candidate.cell_px},
                                          {"held_out_loss", candidate.loss},
                                          {"median_px", candidate.median_px}});
  if (result.bias_kl) (*json)["bias_kl"] = *result.bias_kl;
  if (result.neighbor_correlation)
    (*json)["neighbor_correlation"] = *result.neighbor_correlation;
  if (const auto& known = result.camera.uncertainty)
    (*json)["uncertainty"] = {
        {"median_px", known->lattice.MedianPx()},
        {"max_trusted_px", known->max_deviation_px},
        {"trusted_part", known->TrustedPart(camera.image_size(), area)}};
  if (result.line_spread)
    (*json)["line_spread"] = {{"rms_m", result.line_spread->rms_m},
                              {"max_m", result.line_spread->max_m}};
}

void AddVerdict(const Verdict& verdict, Json* json) {
  (*json)["verdict"] = verdict.word;
  (*json)["reasons"] = verdict.reasons;
}

const char* Status(bool converged, bool is_interrupted) {
  if (is_interrupted) return "interrupted";
  return converged ? "converged" : "not converged";
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

}  // namespace

std::string FormatResultJson(const CalibrationResult& result, uint64_t seed,
                             int64_t peak_memory_bytes) {
  Json json;
  json["status"] = Status(result.converged, result.checkpoint.has_value());
  AddCamera(result, &json);
  json["seconds"] = result.seconds;
  json["peak_memory_bytes"] = peak_memory_bytes;
  json["seed"] = seed;
  AddVerdict(result.verdict, &json);
  return json.dump(2) + "\n";
}

std::string FormatResultJson(const RigResult& result, uint64_t seed,
                             int64_t peak_memory_bytes) {
  const RigCounts counts = Count(result);
  Json json;
  json["status"] =
      Status(result.converged, result.cameras[0].checkpoint.has_value());
  json["model"] = result.cameras.front().camera.camera->Name();
  json["parameters"] = counts.parameters;
  json["images"] = {{"used", counts.images},
                    {"rejected", RejectedInRig(result)}};
  json["features"] = {{"used", counts.features},
                      {"rejected", counts.rejected_features}};
  json["training"] = FiguresJson(TrainingFigures(result));
  if (const auto held_out = HeldOutFigures(result)) {
    json["held_out"] = FiguresJson(*held_out);
    json["held_out"]["by"] = HeldOutBy(result.cross_validated);
  }
  for (const Baseline& baseline : result.baselines)
    json["baselines"].push_back(BaselineJson(result, baseline));
  for (size_t c = 0; c < result.cameras.size(); ++c)
    json["cameras"].push_back(CameraOfRig(result, c));
  json["seconds"] = result.seconds;
  json["peak_memory_bytes"] = peak_memory_bytes;
  json["seed"] = seed;
  AddVerdict(result.verdict, &json);
  return json.dump(2) + "\n";
}

}  // namespace raygrid
