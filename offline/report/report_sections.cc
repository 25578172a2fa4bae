#include "report/report_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evaluation/board_flatness.h"
#include "evaluation/rounded_text.h"
#include "report/plots.h"

namespace raygrid {
namespace {

std::string Optional(const std::optional<double>& value, const char* format) {
  return value ? fmt::format(fmt::runtime(format), *value) : "&ndash;";
}

HtmlRow MakeModelRow(const std::string& name, int num_parameters,
                     const ErrorMetrics& training,
                     const std::optional<ErrorMetrics>& held_out,
                     const std::optional<ErrorMetrics>& held_out_deformed,
                     const std::optional<double>& bias_kl) {
  return {name,
          std::to_string(num_parameters),
          FormatPixels(training.median_px),
          held_out ? FormatPixels(held_out->median_px) : "&ndash;",
          held_out ? FormatPixels(held_out->rms_px) : "&ndash;",
          held_out_deformed ? FormatPixels(held_out_deformed->median_px)
                            : "&ndash;",
          Optional(bias_kl, "{:.3f}")};
}

std::string MakeBoardFigure(const Board& board, const BoardFlatness& shape) {
  const int knot_spacing_px =
      std::clamp(480 / std::max(board.columns, 1), 4, 40);
  std::vector<double> heights_um;
  for (const double height_m : shape.height_m)
    heights_um.push_back(1e6 * height_m);
  const double limit_um = std::max(1e6 * shape.max_height_m, 1.0);
  return EmbedHtmlImage(
      HeatMap(heights_um, board.columns, -limit_um, limit_um, knot_spacing_px),
      fmt::format("Board {}: out-of-plane deformation {:.0f} &micro;m RMS, "
                  "{:.0f} &micro;m max; in-plane deviation {:.0f} &micro;m RMS",
                  board.id, 1e6 * shape.rms_height_m, 1e6 * shape.max_height_m,
                  1e6 * shape.rms_shift_m),
      {"column",
       "row",
       {"0", std::to_string(board.columns - 1)},
       {"0", std::to_string(board.rows - 1)}},
      MakeHtmlColorBar({ColorScale::kEven, "height",
                        fmt::format("{:.0f}", -limit_um),
                        fmt::format("{:.0f} &micro;m", limit_um)}),
      "board");
}

}  // namespace

std::string FormatPixels(double value) { return FormatThreeDigits(value); }

std::string MakeAssessmentSection(const Assessment& assessment) {
  std::string html =
      fmt::format("<div class=\"verdict {0}\"><h2>Verdict: {0}</h2>\n",
                  EscapeHtml(assessment.word));
  if (!assessment.reasons.empty()) html += "<ul>\n";
  for (const std::string& reason : assessment.reasons)
    html += fmt::format("<li>{}</li>\n", EscapeHtml(reason));
  if (!assessment.reasons.empty()) html += "</ul>\n";
  return html + "</div>\n";
}

std::string MakeErrorTable(const std::vector<HtmlRow>& rows) {
  return MakeHtmlTable({"", "median px", "RMS px", "max px", "features"}, rows);
}

HtmlRow FormatMetricsRow(const std::string& name, const ErrorMetrics& metrics) {
  return {name, FormatPixels(metrics.median_px), FormatPixels(metrics.rms_px),
          fmt::format("{:.3f}", metrics.max_px), std::to_string(metrics.count)};
}

void AddModelRows(const std::string& prefix, const CalibrationResult& result,
                  std::vector<HtmlRow>* rows) {
  if (result.parametric_models.empty()) return;
  rows->push_back(MakeModelRow(
      prefix + "<b>" + result.camera.camera->Name() + "</b>",
      result.num_parameters, *result.camera.training, result.camera.held_out,
      result.held_out_deformed, result.bias_kl));
  for (const ModelMetrics& other : result.parametric_models)
    rows->push_back(MakeModelRow(
        prefix + EscapeHtml(other.model), other.num_parameters, other.training,
        other.held_out, other.held_out_deformed, other.bias_kl));
  if (result.noise_bias_kl)
    rows->push_back({prefix + "white noise", "", "", "", "", "",
                     fmt::format("{:.3f}", *result.noise_bias_kl)});
}

std::string MakeModelTable(const std::vector<HtmlRow>& rows) {
  return MakeHtmlTable(
      {"", "parameters", "training median px", "held-out median px",
       "held-out RMS px", "median px with per-view deformation", "bias KL"},
      rows);
}

std::string MakeBoardSection(const Pattern& pattern) {
  std::string html = "<h2>Target geometry</h2>\n<div class=\"pictures\">\n";
  for (const Board& board : pattern.boards)
    html += MakeBoardFigure(board, MeasureFlatness(board));
  return html + "</div>\n";
}

std::string MakeRigidTargetSection(
    const std::vector<std::string>& rigid_target_summary) {
  if (rigid_target_summary.empty()) return "";
  std::string html = "<h2>Rigid multi-board target</h2>\n<ul>\n";
  for (const std::string& sentence : rigid_target_summary)
    html += "<li>" + EscapeHtml(sentence) + "</li>\n";
  return html + "</ul>\n";
}

// Returns one bar per image, proportional to the deformation of its target.
std::string MakeDeformationBars(const BoardDeformation& bends) {
  const double max_rms_m = bends.views[bends.most_deformed].rms_m;
  std::string html = "<div class=\"bars\">";
  for (const BoardDeformation::View& view : bends.views)
    html += fmt::format(
        "<i style=\"height: {:.1f}%\" title=\"{}, board {}: {:.3f} "
        "mm\"></i>\n",
        100 * view.rms_m / std::max(max_rms_m, 1e-12), EscapeHtml(view.image),
        view.board, 1e3 * view.rms_m);
  return html + "</div>\n";
}

std::string MakeDeformationSection(const BoardDeformation& bends,
                                   const Pattern& pattern) {
  const BoardDeformation::View& most = bends.views[bends.most_deformed];
  std::string html =
      "<h2>Per-view target deformation</h2>\n<figure><figcaption>Deformation "
      "relative to the mean shape, one bar per image" +
      fmt::format(": {:.3f} mm RMS, {:.3f} mm max", 1e3 * bends.rms_m,
                  1e3 * most.rms_m) +
      "</figcaption>\n" + MakeDeformationBars(bends) + "</figure>\n";
  const Board* board = pattern.FindBoard(most.board);
  if (!board ||
      bends.heights_m.size() != static_cast<size_t>(board->num_points()))
    return html;
  const int knot_spacing_px =
      std::clamp(480 / std::max(board->columns, 1), 4, 40);
  std::vector<double> heights_um;
  double limit_um = 1;
  for (const double height_m : bends.heights_m) {
    heights_um.push_back(1e6 * height_m);
    limit_um = std::max(limit_um, std::abs(heights_um.back()));
  }
  return html + "<div class=\"pictures\">\n" +
         EmbedHtmlImage(
             HeatMap(heights_um, board->columns, -limit_um, limit_um,
                     knot_spacing_px),
             fmt::format("Board {} in {}: height relative to the mean shape",
                         board->id, EscapeHtml(most.image)),
             {"column",
              "row",
              {"0", std::to_string(board->columns - 1)},
              {"0", std::to_string(board->rows - 1)}},
             MakeHtmlColorBar({ColorScale::kEven, "height",
                               fmt::format("{:.0f}", -limit_um),
                               fmt::format("{:.0f} &micro;m", limit_um)}),
             "bend") +
         "</div>\n";
}

std::string MakeGlossarySection() {
  return "<h2>Glossary</h2>\n<ul>\n<li><b>predicted uncertainty</b>: standard "
         "deviation of a coordinate of a distant point's projection, from the "
         "noise and distribution of the features.</li>\n<li><b>valid "
         "region</b>: where features support the camera and the predicted "
         "uncertainty is below a limit "
         "(--valid-px).</li>\n<li><b>extrapolated</b>: without features "
         "nearby; only the prior determines the camera "
         "there.</li>\n<li><b>bias</b>: deviation of the residuals in an image "
         "region from noise; compare with the value for white "
         "noise.</li>\n<li><b>correlation</b>: fraction of the squared "
         "residuals that is common to neighbouring features; 0 for white "
         "noise.</li>\n<li><b>held out</b>: error in images that were not used "
         "for calibration.</li>\n<li><b>per-view deformation</b>: held-out "
         "error with a target that may deform between images; pose and "
         "deformation are estimated from half of the features, the error is "
         "that of the other half.</li>\n</ul>\n";
}

std::string MakeSceneSection() {
  return "<div class=\"script\"><h2>Cameras and targets in "
         "3D</h2>\n<figure><figcaption>Drag to rotate, scroll or pinch to "
         "zoom. Axes of the first camera: x right, y down, z forward; <span "
         "id=\"space-scale\"></span></figcaption><canvas "
         "id=\"space\"></canvas></figure></div>\n";
}

}  // namespace raygrid
