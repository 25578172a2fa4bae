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

}  // namespace

std::string FormatResultJson(const CalibrationResult& result, uint64_t seed,
                             int64_t peak_memory_bytes) {
  const CameraModel& camera = *result.camera.camera;
  Json rejected = Json::array();
  for (const RejectedImage& image : result.rejected_images)
    rejected.push_back({{"image", image.image}, {"reason", image.reason}});

  Json json;
  json["status"] = result.converged ? "converged" : "not converged";
  json["model"] = camera.Name();
  json["image_size"] = {camera.image_size().width, camera.image_size().height};
  const Area& area = camera.area();
  json["area"] = {area.x0, area.y0, area.x1, area.y1};
  json["parameters"] = result.num_parameters;
  if (result.cell_px > 0) json["cell_px"] = result.cell_px;
  json["images"] = {{"used", result.features.images.size()},
                    {"rejected", rejected}};
  json["features"] = {{"used", result.features.num_features()},
                      {"rejected", result.rejected_features.size()}};
  if (result.measured_again_rms_px)
    json["features"]["measured_again_rms_px"] = *result.measured_again_rms_px;
  json["training"] = FiguresJson(*result.camera.training);
  if (result.camera.held_out) {
    json["held_out"] = FiguresJson(*result.camera.held_out);
    json["held_out"]["by"] =
        result.cross_validated ? "cross-validation" : "images held out";
  }
  for (const CellCandidate& candidate : result.cell_candidates)
    json["cell_candidates"].push_back({{"cell_px", candidate.cell_px},
                                       {"held_out_loss", candidate.loss},
                                       {"median_px", candidate.median_px}});
  if (result.bias_kl) json["bias_kl"] = *result.bias_kl;
  if (result.neighbor_correlation)
    json["neighbor_correlation"] = *result.neighbor_correlation;
  if (result.line_spread)
    json["line_spread"] = {{"rms_m", result.line_spread->rms_m},
                           {"max_m", result.line_spread->max_m}};
  json["seconds"] = result.seconds;
  json["peak_memory_bytes"] = peak_memory_bytes;
  json["seed"] = seed;
  json["verdict"] = result.verdict.word;
  json["reasons"] = result.verdict.reasons;
  return json.dump(2) + "\n";
}

}  // namespace raygrid
