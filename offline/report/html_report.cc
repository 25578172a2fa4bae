#include "report/html_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "report/pictures.h"
#include "report/uncertainty_picture.h"

namespace raygrid {
namespace {

constexpr char kStyle[] = R"(
:root { color-scheme: light dark; --line: #8884; --pass: #2a8a3e; --warn: #b26a00; --fail: #c62828; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 64rem; margin: auto; padding: 1rem; }
h1, h2 { line-height: 1.2; } h2 { margin-top: 2rem; }
table { border-collapse: collapse; } th, td { text-align: right; padding: .2rem .8rem; border-bottom: 1px solid var(--line); }
th:first-child, td:first-child { text-align: left; }
figure { margin: 0; } figcaption { font-size: .9rem; opacity: .8; }
.pictures { display: grid; gap: 1rem; grid-template-columns: repeat(auto-fit, minmax(min(18rem, 100%), 1fr)); }
.pictures img { width: 100%; height: auto; border-radius: 4px; }
.verdict { border-left: .5rem solid; padding: .2rem 1rem; }
.pass { border-color: var(--pass); } .warn { border-color: var(--warn); } .fail { border-color: var(--fail); }
.scroll { overflow-x: auto; } .pictures .legend img { width: 8rem; }
rect.training { fill: #4a90d9; } rect.held { fill: #d98e4a; } svg text { fill: currentColor; font-size: 11px; }
@media print { h2 { break-after: avoid; } figure { break-inside: avoid; } }
)";

std::string Escape(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '&')
      escaped += "&amp;";
    else if (c == '"')
      escaped += "&quot;";
    else
      escaped += c;
  }
  return escaped;
}

std::string Base64(const std::string& bytes) {
  static const char digits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k)
      group = group << 8 |
              (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0);
    for (size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string Figure(const Image& image, const std::string& caption,
                   const std::string& css_class = "picture") {
  return fmt::format(
      "<figure class=\"{4}\"><img alt=\"{0}\" width=\"{1}\" height=\"{2}\" "
      "src=\"data:image/png;base64,{3}\"><figcaption>{0}</figcaption></"
      "figure>\n",
      Escape(caption), image.size.width, image.size.height,
      Base64(EncodePng(image)), css_class);
}

std::string VerdictSection(const Verdict& verdict) {
  std::string html = fmt::format(
      "<div class=\"verdict {0}\"><h2>Verdict: {0}</h2>\n", verdict.word);
  if (!verdict.reasons.empty()) html += "<ul>\n";
  for (const std::string& reason : verdict.reasons)
    html += fmt::format("<li>{}</li>\n", Escape(reason));
  if (!verdict.reasons.empty()) html += "</ul>\n";
  return html + "</div>\n";
}

std::string FiguresRow(const std::string& name, const ErrorFigures& figures) {
  return fmt::format(
      "<tr><td>{}</td><td>{:.4f}</td><td>{:.4f}</td><td>{:.3f}</td><td>{}</"
      "td></tr>\n",
      name, figures.median_px, figures.rms_px, figures.max_px, figures.count);
}

std::string ErrorTable(const CalibrationResult& result) {
  std::string html =
      "<h2>Reprojection error</h2>\n<div class=\"scroll\"><table>\n"
      "<tr><th></th><th>median px</th><th>RMS px</th><th>largest px</th>"
      "<th>features</th></tr>\n";
  html += FiguresRow("training", *result.camera.training);
  if (result.camera.held_out)
    html += FiguresRow(result.cross_validated ? "held out (cross-validation)"
                                              : "held out (images not used)",
                       *result.camera.held_out);
  return html + "</table></div>\n";
}

std::string ModelTable(const CalibrationResult& result,
                       const std::optional<PackingFigures>& packing) {
  const CameraModel& camera = *result.camera.camera;
  const Area& area = camera.area();
  std::string html = "<h2>Camera</h2>\n<div class=\"scroll\"><table>\n";
  const auto row = [&html](const std::string& name, const std::string& value) {
    html += fmt::format("<tr><td>{}</td><td>{}</td></tr>\n", name, value);
  };
  row("model", camera.Name());
  row("parameters", std::to_string(result.num_parameters));
  if (result.cell_px > 0)
    row("cells", fmt::format("at most {:.1f} px", result.cell_px));
  row("image", fmt::format("{} &times; {} px", camera.image_size().width,
                           camera.image_size().height));
  row("calibrated area", fmt::format("x {:.1f} to {:.1f}, y {:.1f} to {:.1f}",
                                     area.x0, area.x1, area.y0, area.y1));
  row("images used", std::to_string(result.features.images.size()));
  if (result.bias_kl) row("bias (KL)", fmt::format("{:.3f}", *result.bias_kl));
  if (result.neighbor_correlation)
    row("correlation of neighbouring features' errors",
        fmt::format("{:.2f}", *result.neighbor_correlation));
  if (const auto& known = result.camera.uncertainty) {
    row("standard deviation of the projection",
        fmt::format("{:.4f} px (median)", known->lattice.MedianPx()));
    row("trusted",
        fmt::format("{:.0f} % of the image, to {:.4f} px",
                    100 * known->TrustedPart(camera.image_size(), area),
                    known->max_deviation_px));
  }
  if (result.line_spread)
    row("lines pass the point nearest to all by",
        fmt::format("{:.3f} mm (RMS), {:.3f} mm (largest)",
                    1000 * result.line_spread->rms_m,
                    1000 * result.line_spread->max_m));
  if (packing) {
    row("blob", fmt::format("{} bytes", packing->blob_bytes));
    row("un-projection error added by packing",
        fmt::format("{:.2g} px", packing->unproject_error_px));
  }
  if (packing && packing->remap_error_px)
    row("remap geometry error",
        fmt::format("{:.3f} px", *packing->remap_error_px));
  return html + "</table></div>\n";
}

std::string CandidateTable(const CalibrationResult& result) {
  if (result.cell_candidates.size() < 2) return "";
  std::string html =
      "<h2>Grid resolutions tried</h2>\n<div class=\"scroll\"><table>\n"
      "<tr><th>cell px</th><th>held-out median px</th><th>held-out loss "
      "px&sup2;</th></tr>\n";
  for (const CellCandidate& candidate : result.cell_candidates)
    html += fmt::format(
        "<tr><td>{:.1f}{}</td><td>{:.4f}</td><td>{:.5f}</td></tr>\n",
        candidate.cell_px,
        candidate.cell_px == result.cell_px ? " (chosen)" : "",
        candidate.median_px, candidate.loss);
  return html + "</table></div>\n";
}

// Median error of each image, as horizontal bars.
std::string BarChart(const std::string& title, const std::string& css_class,
                     const std::vector<FeatureResidual>& residuals) {
  std::map<std::string, std::vector<double>> norms;
  for (const FeatureResidual& residual : residuals)
    norms[residual.image].push_back(residual.error_px.norm());
  if (norms.empty()) return "";
  double largest = 1e-9;
  for (const auto& [image, values] : norms)
    largest = std::max(largest, Quantile(values, 0.5));
  const int height = static_cast<int>(norms.size()) * 16 + 4;
  std::string html = fmt::format(
      "<h3>{}</h3>\n<div class=\"scroll\"><svg width=\"620\" height=\"{}\" "
      "role=\"img\" "
      "aria-label=\"{}\">\n",
      title, height, title);
  int y = 2;
  for (const auto& [image, values] : norms) {
    const double median = Quantile(values, 0.5);
    html += fmt::format(
        "<text x=\"0\" y=\"{}\">{}</text><rect class=\"{}\" x=\"170\" y=\"{}\" "
        "width=\"{:.1f}\" height=\"12\"/><text x=\"{:.1f}\" "
        "y=\"{}\">{:.3f}</text>\n",
        y + 10, Escape(image), css_class, y, 380 * median / largest,
        176 + 380 * median / largest, y + 10, median);
    y += 16;
  }
  return html + "</svg></div>\n";
}

std::string RejectedSection(const CalibrationResult& result) {
  std::string html;
  if (!result.rejected_images.empty()) {
    html += "<h2>Images not used</h2>\n<ul>\n";
    for (const RejectedImage& image : result.rejected_images)
      html += fmt::format("<li>{}: {}</li>\n", Escape(image.image),
                          Escape(image.reason));
    html += "</ul>\n";
  }
  if (!result.rejected_features.empty()) {
    html += "<h2>Features taken out as outliers</h2>\n<ul>\n";
    for (const FeatureResidual& feature : result.rejected_features)
      html += fmt::format("<li>{}, ({}, {}): {:.2f} px off</li>\n",
                          Escape(feature.image), feature.column, feature.row,
                          feature.error_px.norm());
    html += "</ul>\n";
  }
  return html;
}

std::string PicturesSection(const CalibrationResult& result) {
  const CameraModel& camera = *result.camera.camera;
  const ImageSize& size = camera.image_size();
  const Area& area = camera.area();
  const double full_scale =
      std::max(3 * result.camera.training->median_px, 1e-6);
  std::string html =
      "<h2>Coverage and residuals</h2>\n<div class=\"pictures\">\n";
  html += Figure(CoveragePicture(result.training, size, area),
                 "Coverage: features used; lighter: the calibrated area");
  html += Figure(DirectionPicture(result.training, size, area),
                 "Direction of the nearest residual: noise has no pattern");
  html += Figure(MagnitudePicture(result.training, size, area, full_scale),
                 fmt::format("Magnitude of the nearest residual: black 0, "
                             "bright {:.2f} px and more",
                             full_scale));
  if (result.camera.uncertainty)
    html += Figure(UncertaintyPicture(*result.camera.uncertainty, size, area),
                   "How well the camera is known, by its features' noise");
  html += Figure(DirectionLegend(160), "Colours of the directions", "legend");
  return html + "</div>\n";
}

std::string PageStart(const std::string& heading) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\">\n"
      "<title>raygrid calibration</title>\n<style>{}</style></head>\n<body>\n"
      "<h1>{}</h1>\n",
      kStyle, heading);
}

// ---- Rig -------------------------------------------------------------------

std::string CamerasTable(const RigResult& result) {
  std::string html =
      "<h2>Cameras</h2>\n<div class=\"scroll\"><table>\n"
      "<tr><th></th><th>verdict</th><th>model</th><th>parameters</th>"
      "<th>images</th><th>image px</th></tr>\n";
  for (const CalibrationResult& camera : result.cameras)
    html += fmt::format(
        "<tr><td><a href=\"{0}/report.html\">{0}</a></td><td>{1}</td>"
        "<td>{2}</td><td>{3}</td><td>{4}</td><td>{5} &times; {6}</td></tr>\n",
        Escape(camera.camera.name), camera.verdict.word,
        camera.camera.camera->Name(), camera.num_parameters,
        camera.features.images.size(), camera.camera.camera->image_size().width,
        camera.camera.camera->image_size().height);
  return html + "</table></div>\n";
}

std::string RigErrorTable(const RigResult& result) {
  std::string html =
      "<h2>Reprojection error</h2>\n<div class=\"scroll\"><table>\n"
      "<tr><th></th><th>median px</th><th>RMS px</th><th>largest px</th>"
      "<th>features</th></tr>\n";
  const std::string by =
      result.cross_validated ? "cross-validation" : "instants not used";
  for (size_t c = 0; c < result.cameras.size(); ++c) {
    const CalibrationResult& camera = result.cameras[c];
    const std::string name = Escape(camera.camera.name);
    html += FiguresRow(name + ", training", *camera.camera.training);
    if (camera.camera.held_out)
      html += FiguresRow(name + ", held out, localised alone",
                         *camera.camera.held_out);
    if (c < result.held_out.size() && !result.held_out[c].empty())
      html += FiguresRow(name + ", held out, localised by the rig",
                         ComputeErrorFigures(result.held_out[c]));
  }
  html += FiguresRow("all, training", TrainingFigures(result));
  if (const auto held_out = HeldOutFigures(result))
    html += FiguresRow("all, held out (" + by + "), localised by the rig",
                       *held_out);
  return html + "</table></div>\n";
}

std::string WithDeviation(double value, const std::optional<double>& deviation,
                          double scale) {
  return deviation ? fmt::format("{:.4f} &plusmn; {:.4f}", value * scale,
                                 *deviation * scale)
                   : fmt::format("{:.4f}", value * scale);
}

std::string BaselineTable(const RigResult& result) {
  std::string html =
      "<h2>How the cameras stand to each other</h2>\n"
      "<div class=\"scroll\"><table>\n"
      "<tr><th></th><th>distance mm</th><th>angle degrees</th>"
      "<th>boards seen by both</th></tr>\n";
  for (const Baseline& baseline : result.baselines)
    html += fmt::format(
        "<tr><td>{} to {}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
        Escape(result.cameras[baseline.first].camera.name),
        Escape(result.cameras[baseline.second].camera.name),
        WithDeviation(baseline.distance_m, baseline.distance_sd_m, 1000),
        WithDeviation(baseline.angle_rad, baseline.rotation_sd_rad, 180 / M_PI),
        baseline.num_shared_views);
  return html + "</table></div>\n";
}

}  // namespace

std::string FormatHtmlReport(const CalibrationResult& result,
                             const std::optional<PackingFigures>& packing,
                             const std::optional<BeforeAfter>& example) {
  std::string html = PageStart(
      "Camera calibration" +
      (result.camera.name.empty() ? "" : ": " + Escape(result.camera.name)));
  html += VerdictSection(result.verdict);
  html += ErrorTable(result);
  html += ModelTable(result, packing);
  html += PicturesSection(result);
  if (example) {
    html += "<h2>Before and after</h2>\n<div class=\"pictures\">\n";
    html += Figure(example->before, example->name + " as taken");
    html += Figure(example->after, example->name +
                                       " undistorted by the runtime; black "
                                       "where the camera is not calibrated");
    html += "</div>\n";
  }
  html += "<h2>Median error by image (px)</h2>\n";
  html += BarChart("Training", "training", result.training);
  html += BarChart("Held out", "held", result.held_out);
  html += CandidateTable(result);
  html += RejectedSection(result);
  return html + "</body></html>\n";
}

std::string FormatRigReport(const RigResult& result) {
  return PageStart("Rig calibration") + VerdictSection(result.verdict) +
         CamerasTable(result) + RigErrorTable(result) + BaselineTable(result) +
         "</body></html>\n";
}

}  // namespace raygrid
