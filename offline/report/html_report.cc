#include "report/html_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "dataset/fixed_operating_point.h"
#include "evaluation/line_delay_text.h"
#include "evaluation/rounded_text.h"
#include "report/budget_section.h"
#include "report/html.h"
#include "report/operating_point_section.h"
#include "report/page_data.h"
#include "report/plot_sections.h"
#include "report/report_sections.h"

namespace raygrid {
namespace {

// ---- Errors ----------------------------------------------------------------

std::string MakeErrorSection(const CalibrationResult& result) {
  std::vector<HtmlRow> rows = {
      FormatMetricsRow("training", *result.camera.training)};
  if (result.camera.held_out)
    rows.push_back(FormatMetricsRow(result.cross_validated
                                        ? "held out (cross-validation)"
                                        : "held out (images not used)",
                                    *result.camera.held_out));
  if (result.held_out_deformed)
    rows.push_back(FormatMetricsRow("held out, with per-view deformation",
                                    *result.held_out_deformed));
  std::string html = "<h2>Reprojection error</h2>\n" + MakeErrorTable(rows);
  if (result.camera.held_out)
    html +=
        "<p>Assess the camera by the held-out error, measured on images that "
        "were not used for calibration; the training error is "
        "optimistic.</p>\n";
  if (result.bias_kl && result.noise_bias_kl)
    html += fmt::format(
        "<p>Bias: Kullback&ndash;Leibler divergence of residuals from a normal "
        "distribution, median over 50 &times; 50 cells: <b>{:.3f}</b>; white "
        "noise at the same positions gives <b>{:.3f}</b>.</p>\n",
        *result.bias_kl, *result.noise_bias_kl);
  return html +
         "<figure class=\"script\"><figcaption>Cumulative distribution of "
         "errors</figcaption><div class=\"chart\"><canvas "
         "id=\"distribution\"></canvas></div></figure>\n";
}

std::string MakeComparisonSection(const CalibrationResult& result) {
  std::vector<HtmlRow> rows;
  AddModelRows("", result, &rows);
  if (rows.empty()) return "";
  return "<h2>Other models calibrated from the same features</h2>\n" +
         MakeModelTable(rows);
}

std::string MakeCandidateSection(const CalibrationResult& result) {
  if (result.knot_spacing_candidates.size() < 2) return "";
  std::vector<HtmlRow> rows;
  for (const KnotSpacingCandidate& candidate : result.knot_spacing_candidates)
    rows.push_back(
        {fmt::format("{:.1f}{}", candidate.knot_spacing_px,
                     candidate.knot_spacing_px == result.knot_spacing_px
                         ? " (chosen)"
                         : ""),
         FormatPixels(candidate.median_px),
         fmt::format("{:.5f}", candidate.loss)});
  return "<h2>Knot spacings tested</h2>\n<p>The medium spacing is kept unless "
         "another spacing has a significantly lower held-out loss.</p>\n" +
         MakeHtmlTable({"knot spacing px", "held-out median px",
                        "held-out loss px&sup2;"},
                       rows);
}

// ---- Camera ----------------------------------------------------------------

void AddUncertaintyRows(const CalibrationResult& result,
                        std::vector<HtmlRow>* rows) {
  const CameraModel& camera = *result.camera.camera;
  if (const auto& known = result.camera.uncertainty) {
    rows->push_back({"predicted uncertainty",
                     FormatPixels(known->lattice.MedianPx()) + " px (median)"});
    rows->push_back(
        {"valid region",
         fmt::format(
             "{:.0f} % of the image, with an uncertainty below {:.2g} px",
             100 * ComputeValidShare(camera, known->mask),
             known->max_stddev_px)});
    if (result.camera.stack) {
      const auto everywhere = ComputeMaxUncertainty(result.camera);
      rows->push_back(
          {"valid over the whole operating range",
           fmt::format("{:.0f} % of the image",
                       100 * ComputeValidShare(camera, everywhere->mask))});
    }
    rows->push_back(
        {"correlated residuals",
         fmt::format("the uncertainty is {:.2f} times that of white noise "
                     "(jackknife over groups of images)",
                     result.jackknife_scale)});
  }
  if (const auto& circle = camera.image_circle())
    rows->push_back(
        {"image circle", fmt::format("radius {:.1f} px, centre {:.1f}, {:.1f}",
                                     circle->radii_px.x(), circle->center.x(),
                                     circle->center.y())});
  if (result.line_delay)
    rows->push_back(
        {"line delay", EscapeHtml(FormatLineDelay(
                           *result.line_delay, camera.image_size().height))});
  if (result.fleet_distance)
    rows->push_back(
        {"distance from the fleet", EscapeHtml(result.fleet_distance->Text())});
  if (result.noncentrality)
    rows->push_back({"distance of observation lines from their common point",
                     fmt::format("{:.3f} mm RMS, {:.3f} mm max",
                                 1000 * result.noncentrality->rms_m,
                                 1000 * result.noncentrality->max_m)});
}

void AddPackingRows(const PackingMetrics& packing, std::vector<HtmlRow>* rows) {
  if (packing.blob_bytes > 0) {
    rows->push_back({"blob", fmt::format("{} bytes", packing.blob_bytes)});
    rows->push_back({"unprojection error of packing",
                     fmt::format("{:.2g} px", packing.unproject_error_px)});
  }
  if (packing.remap_error_px)
    rows->push_back(
        {"remap error", fmt::format("{:.2g} px", *packing.remap_error_px)});
  if (const auto& view = packing.view)
    rows->push_back(
        {"undistorted images (view.camera.yaml)",
         fmt::format("{} x {} px, fx {:.6g}, fy {:.6g}, cx {:.6g}, cy {:.6g}",
                     view->size.width, view->size.height, view->focal_px.x(),
                     view->focal_px.y(), view->center_px.x(),
                     view->center_px.y())});
  for (const std::string& warning : packing.warnings)
    rows->push_back({"camera.raygrid", EscapeHtml(warning)});
}

// Returns the predicted uncertainty in one sentence, and as fractions of the
// image.
std::string MakeUncertaintySection(const CalibrationResult& result) {
  const auto& uncertainty = result.camera.uncertainty;
  if (!uncertainty || !uncertainty->HasStdDevs()) return "";
  const CameraModel& camera = *result.camera.camera;
  const UncertaintySummary summary = SummarizeUncertainty(camera, *uncertainty);
  HtmlRow head = {"predicted uncertainty (1 &sigma;) below"},
          row = {"fraction of the image"};
  for (size_t k = 0; k < kShareLimitsPx.size(); ++k) {
    head.push_back(fmt::format("{:g} px", kShareLimitsPx[k]));
    row.push_back(fmt::format("{:.0f} %", 100 * summary.share_below[k]));
  }
  return "<h2>Uncertainty of the camera</h2>\n<p>" +
         DescribeUncertainty(summary, *uncertainty, camera) + "</p>\n" +
         MakeHtmlTable(head, {row});
}

std::string MakeCameraSection(const CalibrationResult& result,
                              const std::optional<PackingMetrics>& packing) {
  const CameraModel& camera = *result.camera.camera;
  const Area& area = camera.area();
  std::vector<HtmlRow> rows = {
      {"model", camera.Name()},
      {"parameters", std::to_string(result.num_parameters)}};
  if (result.knot_spacing_px > 0)
    rows.push_back({"knot spacing",
                    fmt::format("at most {:.1f} px", result.knot_spacing_px)});
  rows.push_back(
      {"image", fmt::format("{} &times; {} px", camera.image_size().width,
                            camera.image_size().height)});
  rows.push_back(
      {"calibrated area", fmt::format("x {:.1f} to {:.1f}, y {:.1f} to {:.1f}",
                                      area.x0, area.x1, area.y0, area.y1)});
  rows.push_back(
      {"images used", std::to_string(result.features.images.size())});
  if (result.refinement_rms_px)
    rows.push_back({"features refined with the model moved by",
                    FormatPixels(*result.refinement_rms_px) + " px (RMS)"});
#define RAYGRID_METRIC(name, title, unit, meaning) \
  if (result.name)                                 \
    rows.push_back({title, FormatMetric(*result.name, unit) + ". " meaning});
#include "evaluation/metrics.inc"
  AddUncertaintyRows(result, &rows);
  if (packing) AddPackingRows(*packing, &rows);
  return "<h2>Camera</h2>\n" + MakeHtmlTable({}, rows);
}

std::string GridSection(const CalibrationResult& result) {
  if (result.knot_spacing_px <= 0) return "";
  return "<div class=\"script\"><h2>Control "
         "points</h2>\n<figure><figcaption>Control points of the B-spline over "
         "the image. <span class=\"key seen\"></span> observed <span "
         "class=\"key few\"></span> fewer than 3 features <span class=\"key "
         "unseen\"></span> extrapolated (determined by the smoothness "
         "prior)</figcaption><canvas id=\"grid\"></canvas></figure></div>\n";
}

// ---- Images ----------------------------------------------------------------

std::map<std::string, std::vector<double>> GroupNormsByImage(
    const std::vector<FeatureResidual>& residuals) {
  std::map<std::string, std::vector<double>> norms;
  for (const FeatureResidual& residual : residuals)
    norms[residual.image].push_back(residual.error_px.norm());
  return norms;
}

// Returns a table with the data of the bars, for browsers without scripts and
// for print.
std::string MakeImageTable(const CalibrationResult& result) {
  auto training = GroupNormsByImage(result.training);
  auto held_out = GroupNormsByImage(result.held_out);
  std::map<std::string, HtmlRow> rows;
  for (const auto* norms : {&training, &held_out})
    for (const auto& [image, values] : *norms)
      rows[image] = {EscapeHtml(image), "&ndash;", "&ndash;"};
  for (const auto& [image, values] : training)
    rows[image][1] = FormatPixels(Quantile(values, 0.5));
  for (const auto& [image, values] : held_out)
    rows[image][2] = FormatPixels(Quantile(values, 0.5));
  std::vector<HtmlRow> list;
  for (const auto& [image, row] : rows) list.push_back(row);
  return "<details><summary>As a table</summary>\n" +
         MakeHtmlTable({"image", "training median px", "held-out median px"},
                       list) +
         "</details>\n";
}

std::string MakeImagesSection(const CalibrationResult& result) {
  return "<h2>Error by image</h2>\n<div class=\"script\"><p>Select an image by "
         "its bar to show its residuals.</p>\n<div class=\"chart\"><canvas "
         "id=\"bars\"></canvas></div>\n<p><button "
         "id=\"previous\">&larr;</button> <select id=\"image\" "
         "aria-label=\"image\"></select> <button id=\"next\">&rarr;</button> "
         "<span "
         "id=\"image-figures\"></span></p>\n<figure><figcaption>Residuals, "
         "magnified <span id=\"enlarged\"></span> times: <span class=\"key "
         "training\"></span> training <span class=\"key held\"></span> held "
         "out <span class=\"key rejected\"></span> outliers "
         "(crosses)</figcaption><canvas "
         "id=\"arrows\"></canvas></figure></div>\n" +
         MakeImageTable(result);
}

// Returns the groups of near-duplicate images.
std::string MakeNearDuplicatesSection(const CalibrationResult& result) {
  if (result.near_duplicates.empty()) return "";
  std::string html = "<h2>Near-duplicate views</h2>\n<ul>\n";
  for (const NearDuplicates& group : result.near_duplicates) {
    html += fmt::format("<li>{} represents {} more: ", EscapeHtml(group.image),
                        group.others.size());
    for (size_t i = 0; i < group.others.size(); ++i)
      html += (i > 0 ? ", " : "") + EscapeHtml(group.others[i]);
    html += "</li>\n";
  }
  return html + "</ul>\n";
}

std::string MakeRejectedSection(const CalibrationResult& result) {
  constexpr size_t kMaxLines = 300;
  std::string html;
  if (!result.rejected_images.empty()) {
    html += "<h2>Rejected images</h2>\n<ul>\n";
    for (const RejectedImage& image : result.rejected_images)
      html += fmt::format("<li>{}: {}</li>\n", EscapeHtml(image.image),
                          EscapeHtml(image.reason));
    html += "</ul>\n";
  }
  if (result.rejected_features.empty()) return html;
  html += fmt::format("<h2>Outliers: {} features</h2>\n<ul>\n",
                      result.rejected_features.size());
  std::vector<const FeatureResidual*> worst;
  for (const FeatureResidual& feature : result.rejected_features)
    worst.push_back(&feature);
  std::stable_sort(worst.begin(), worst.end(), [](auto* a, auto* b) {
    return a->error_px.squaredNorm() > b->error_px.squaredNorm();
  });
  for (size_t i = 0; i < std::min(worst.size(), kMaxLines); ++i)
    html += fmt::format(
        "<li>{}, board {}, feature ({}, {}): residual {:.2f} px</li>\n",
        EscapeHtml(worst[i]->image), worst[i]->board, worst[i]->column,
        worst[i]->row, worst[i]->error_px.norm());
  html += "</ul>\n";
  if (worst.size() > kMaxLines)
    html += fmt::format("<p>The {} largest; all are in residuals.csv.</p>\n",
                        kMaxLines);
  return html;
}

std::string MakeExampleSection(const BeforeAfter& example) {
  return "<h2>Before and after</h2>\n<div "
         "class=\"pictures\">\n<figure><figcaption>Original</figcaption>" +
         MakeHtmlImage(example.before, "Original") +
         "</figure>\n<figure><figcaption>Undistorted by the runtime; black "
         "where the camera is not calibrated</figcaption>" +
         MakeHtmlImage(example.after, "Undistorted by the runtime") +
         "</figure>\n</div>\n";
}

std::string MakeTrialFigure(const char* caption, const char* id) {
  return fmt::format(
      "<figure><figcaption>{}</figcaption><div class=\"marked\"><canvas "
      "id=\"{}\"></canvas><span hidden></span></div></figure>\n",
      caption, id);
}

// Filled by the script page/trial.js, and displayed once the runtime is loaded.
std::string MakeTrialSection(const std::string& blob) {
  return "<div id=\"trial\" hidden data-blob=\"" + Base64(blob) +
         "\">\n<h2>Undistort an image</h2>\n<p>Drop an image of this camera "
         "here. It is processed locally by the code of the embedded runtime. "
         "Hover over a pixel to see its ray.</p>\n<p><label>Or choose one "
         "<input type=\"file\" id=\"trial-file\" "
         "accept=\"image/*\"></label></p>\n<p><label>View <select "
         "id=\"trial-kind\"></select></label> <label id=\"trial-angle-row\">of "
         "<input type=\"range\" id=\"trial-angle\" min=\"5\"> <span "
         "id=\"trial-degrees\"></span> across</label></p>\n<p "
         "id=\"trial-message\" role=\"status\"></p>\n<div "
         "class=\"pictures\">\n" +
         MakeTrialFigure("Original", "trial-taken") +
         MakeTrialFigure("Undistorted: <span id=\"trial-figures\"></span>",
                         "trial-made") +
         "</div>\n</div>\n";
}

}  // namespace

std::string FormatHtmlReport(
    const CalibrationResult& result,
    const std::optional<PackingMetrics>& packing,
    const std::optional<BeforeAfter>& example, const ThumbnailTexts& thumbnails,
    const std::string& blob,
    const std::vector<std::string>& rigid_target_summary) {
  const std::string name =
      result.camera.name.empty() ? "" : ": " + EscapeHtml(result.camera.name);
  std::string html = PageStart("Camera calibration" + name);
  html += MakeAssessmentSection(result.assessment);
  html += MakeErrorSection(result);
  if (result.camera.stack)
    html += MakeOperatingPointSection(*result.camera.stack);
  if (result.budget) html += MakeBudgetSection(*result.budget);
  html += MakeComparisonSection(result);
  html += MakeUncertaintySection(result);
  html += MakePlotsSection(result);
  html += MakeImagesSection(result);
  if (example) html += MakeExampleSection(*example);
  if (!blob.empty()) html += MakeTrialSection(blob);
  html += MakeCameraSection(result, packing);
  html += GridSection(result);
  html += MakeLinesSection(result);
  html += MakeSceneSection();
  html += MakeBoardSection(result.pattern) +
          MakeRigidTargetSection(rigid_target_summary);
  if (result.bends)
    html += MakeDeformationSection(*result.bends, result.pattern);
  html += MakeCandidateSection(result);
  html += MakeNearDuplicatesSection(result);
  html += MakeRejectedSection(result);
  html += MakeGlossarySection();
  return html + PageEnd(FormatPageData(result, thumbnails), !blob.empty());
}

}  // namespace raygrid
