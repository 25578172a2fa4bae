#include "report/rig_report.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "evaluation/rounded_text.h"
#include "report/page_data.h"
#include "report/report_sections.h"

namespace raygrid {
namespace {

std::string MakeCamerasTable(const RigResult& result) {
  std::vector<HtmlRow> rows;
  for (const CalibrationResult& camera : result.cameras) {
    const std::string name = EscapeHtml(camera.camera.name);
    const ImageSize& size = camera.camera.camera->image_size();
    rows.push_back(
        {fmt::format("<a href=\"{0}/report.html\">{0}</a>", name),
         EscapeHtml(camera.assessment.word), camera.camera.camera->Name(),
         camera.has_known_intrinsics ? "known"
                                     : std::to_string(camera.num_parameters),
         std::to_string(camera.features.images.size()),
         fmt::format("{} &times; {}", size.width, size.height)});
  }
  return "<h2>Cameras</h2>\n" +
         MakeHtmlTable(
             {"", "verdict", "model", "parameters", "images", "image px"},
             rows);
}

std::string MakeRigErrorTable(const RigResult& result) {
  const std::string by =
      result.cross_validated ? "cross-validation" : "frames not used";
  std::vector<HtmlRow> rows;
  for (size_t c = 0; c < result.cameras.size(); ++c) {
    const CalibrationResult& camera = result.cameras[c];
    const std::string name = EscapeHtml(camera.camera.name);
    rows.push_back(
        FormatMetricsRow(name + ", training", *camera.camera.training));
    if (camera.camera.held_out)
      rows.push_back(FormatMetricsRow(
          name + ", held out, pose from this camera", *camera.camera.held_out));
    if (c < result.held_out.size() && !result.held_out[c].empty())
      rows.push_back(FormatMetricsRow(name + ", held out, pose from the rig",
                                      ComputeErrorMetrics(result.held_out[c])));
  }
  rows.push_back(
      FormatMetricsRow("all, training", ComputeTrainingMetrics(result)));
  if (const auto held_out = ComputeHeldOutMetrics(result))
    rows.push_back(FormatMetricsRow(
        "all, held out (" + by + "), pose from the rig", *held_out));
  return "<h2>Reprojection error</h2>\n" + MakeErrorTable(rows);
}

// Returns a table of the models compared for each camera, evaluated on its own
// images.
std::string MakeRigComparisonTable(const RigResult& result) {
  std::vector<HtmlRow> rows;
  for (const CalibrationResult& camera : result.cameras)
    AddModelRows(EscapeHtml(camera.camera.name) + ", ", camera, &rows);
  if (rows.empty()) return "";
  return "<h2>Other models calibrated from the same features</h2>\n" +
         MakeModelTable(rows) +
         "<p>The other models are fitted per camera, and poses of held-out "
         "images are estimated per camera.</p>\n";
}

std::string FormatEstimateCell(double value,
                               const std::optional<double>& deviation,
                               double scale) {
  return deviation
             ? FormatWithStdDev(value * scale, *deviation * scale, " &plusmn; ")
             : FormatThreeDigits(value * scale);
}

std::string MakeBaselineTable(const RigResult& result) {
  std::vector<HtmlRow> rows;
  for (const Baseline& baseline : result.baselines)
    rows.push_back(
        {fmt::format("{} to {}",
                     EscapeHtml(result.cameras[baseline.first].camera.name),
                     EscapeHtml(result.cameras[baseline.second].camera.name)),
         FormatEstimateCell(baseline.distance_m, baseline.distance_stddev_m,
                            1000),
         FormatEstimateCell(baseline.angle_rad, baseline.rotation_stddev_rad,
                            180 / M_PI),
         std::to_string(baseline.num_shared_views)});
  return "<h2>Relative camera poses</h2>\n" +
         MakeHtmlTable({"", "baseline mm", "rotation degrees", "common views"},
                       rows);
}

// Returns the per-view deformation over the views of all cameras. A target that
// several cameras observe in one frame has a single deformation.
std::optional<BoardDeformation> GetCommonDeformation(const RigResult& result) {
  std::map<std::pair<std::string, int>, double> rms_m;
  BoardDeformation all;
  double max_deformation_m = -1, square_m2 = 0;
  for (const CalibrationResult& camera : result.cameras) {
    if (!camera.bends) continue;
    for (const BoardDeformation::View& view : camera.bends->views)
      rms_m[{view.image, view.board}] = view.rms_m;
    const double camera_rms_m =
        camera.bends->views[camera.bends->most_deformed].rms_m;
    if (camera_rms_m <= max_deformation_m) continue;
    max_deformation_m = camera_rms_m;
    all.heights_m = camera.bends->heights_m;
  }
  if (rms_m.empty()) return std::nullopt;
  for (const auto& [view, bend_m] : rms_m) {
    if (bend_m == max_deformation_m)
      all.most_deformed = static_cast<int>(all.views.size());
    all.views.push_back({view.first, view.second, bend_m});
    square_m2 += bend_m * bend_m;
  }
  all.rms_m = std::sqrt(square_m2 / static_cast<double>(all.views.size()));
  return all;
}

}  // namespace

std::string FormatRigReport(
    const RigResult& result, const std::optional<StereoExample>& stereo,
    const std::vector<std::string>& rigid_target_summary) {
  const std::optional<BoardDeformation> bends = GetCommonDeformation(result);
  return PageStart("Rig calibration") +
         MakeAssessmentSection(result.assessment) + MakeCamerasTable(result) +
         MakeRigErrorTable(result) + MakeRigComparisonTable(result) +
         MakeBaselineTable(result) +
         (stereo ? MakeStereoSection(*stereo) : "") + MakeSceneSection() +
         MakeBoardSection(result.pattern) +
         MakeRigidTargetSection(rigid_target_summary) +
         (bends ? MakeDeformationSection(*bends, result.pattern) : "") +
         MakeGlossarySection() + PageEnd(FormatPageData(result));
}

}  // namespace raygrid
