#include "report/report_sections.h"

#include <fmt/format.h>

#include <algorithm>

#include "evaluation/board_shape.h"
#include "report/pictures.h"

namespace raygrid {
namespace {

std::string Optional(const std::optional<double>& value, const char* format) {
  return value ? fmt::format(fmt::runtime(format), *value) : "&ndash;";
}

HtmlRow ModelRow(const std::string& name, int num_parameters,
                 const ErrorFigures& training,
                 const std::optional<ErrorFigures>& held_out,
                 const std::optional<double>& bias_kl) {
  return {name,
          std::to_string(num_parameters),
          Px(training.median_px),
          held_out ? Px(held_out->median_px) : "&ndash;",
          held_out ? Px(held_out->rms_px) : "&ndash;",
          Optional(bias_kl, "{:.3f}")};
}

std::string BoardFigure(const Board& board, const BoardShape& shape) {
  const int cell_px = std::clamp(480 / std::max(board.columns, 1), 4, 40);
  std::vector<double> heights_um;
  for (const double height_m : shape.height_m)
    heights_um.push_back(1e6 * height_m);
  const double limit_um = std::max(1e6 * shape.max_height_m, 1.0);
  return HtmlPicture(
      HeatMap(heights_um, board.columns, -limit_um, limit_um, cell_px),
      fmt::format("Board {}: height above the nearest plane, {:.0f} &micro;m "
                  "RMS, {:.0f} &micro;m at most; within the plane points are "
                  "{:.0f} &micro;m (RMS) from where they should be",
                  board.id, 1e6 * shape.rms_height_m, 1e6 * shape.max_height_m,
                  1e6 * shape.rms_shift_m),
      {"column",
       "row",
       {"0", std::to_string(board.columns - 1)},
       {"0", std::to_string(board.rows - 1)}},
      HtmlColorBar({ColorScale::kEven, "height",
                    fmt::format("{:.0f}", -limit_um),
                    fmt::format("{:.0f} &micro;m", limit_um)}),
      "board");
}

}  // namespace

std::string Px(double value) { return fmt::format("{:.4f}", value); }

std::string VerdictSection(const Verdict& verdict) {
  std::string html =
      fmt::format("<div class=\"verdict {0}\"><h2>Verdict: {0}</h2>\n",
                  EscapeHtml(verdict.word));
  if (!verdict.reasons.empty()) html += "<ul>\n";
  for (const std::string& reason : verdict.reasons)
    html += fmt::format("<li>{}</li>\n", EscapeHtml(reason));
  if (!verdict.reasons.empty()) html += "</ul>\n";
  return html + "</div>\n";
}

std::string ErrorTable(const std::vector<HtmlRow>& rows) {
  return HtmlTable({"", "median px", "RMS px", "largest px", "features"}, rows);
}

HtmlRow FiguresRow(const std::string& name, const ErrorFigures& figures) {
  return {name, Px(figures.median_px), Px(figures.rms_px),
          fmt::format("{:.3f}", figures.max_px), std::to_string(figures.count)};
}

void AddModelRows(const std::string& prefix, const CalibrationResult& result,
                  std::vector<HtmlRow>* rows) {
  if (result.parametric_models.empty()) return;
  rows->push_back(
      ModelRow(prefix + "<b>" + result.camera.camera->Name() + "</b>",
               result.num_parameters, *result.camera.training,
               result.camera.held_out, result.bias_kl));
  for (const ModelFigures& other : result.parametric_models)
    rows->push_back(ModelRow(prefix + EscapeHtml(other.model),
                             other.num_parameters, other.training,
                             other.held_out, other.bias_kl));
  if (result.noise_bias_kl)
    rows->push_back({prefix + "pure noise", "", "", "", "",
                     fmt::format("{:.3f}", *result.noise_bias_kl)});
}

std::string ModelTable(const std::vector<HtmlRow>& rows) {
  return HtmlTable({"", "parameters", "training median px",
                    "held-out median px", "held-out RMS px", "bias KL"},
                   rows);
}

std::string BoardSection(const Pattern& pattern) {
  std::string html =
      "<h2>How flat the board is</h2>\n<div class=\"pictures\">\n";
  for (const Board& board : pattern.boards)
    html += BoardFigure(board, MeasureBoardShape(board));
  return html + "</div>\n";
}

std::string WordsSection() {
  return "<h2>Words</h2>\n<ul>\n"
         "<li><b>trusted</b>: the part of the image where the camera is known "
         "to half the features' noise, or to 0.025 px.</li>\n"
         "<li><b>leave open</b>: how far, in the median pixel, projections may "
         "move before the features contradict (one standard deviation).</li>\n"
         "<li><b>bias</b>: how unlike noise the residuals of one region of the "
         "image are; compare with what pure noise would have.</li>\n"
         "<li><b>correlation</b>: the part of the squared errors that "
         "neighbouring features share; 0 is pure noise.</li>\n"
         "<li><b>held out</b>: errors in images that the camera was not "
         "calibrated with.</li>\n</ul>\n";
}

std::string SpaceSection() {
  return "<div class=\"script\"><h2>Cameras and boards in space</h2>\n"
         "<figure><figcaption>Drag to turn, wheel or pinch to zoom. Axes of "
         "the "
         "first camera: x right, y down, z forward; <span "
         "id=\"space-scale\"></span></figcaption><canvas "
         "id=\"space\"></canvas></figure></div>\n";
}

}  // namespace raygrid
