#include "report/html_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "evaluation/board_shape.h"
#include "report/html.h"
#include "report/page_data.h"
#include "report/pictures.h"
#include "report/uncertainty_picture.h"

namespace raygrid {
namespace {

constexpr int kPictureWidthPx = 800;

std::string Px(double value) { return fmt::format("{:.4f}", value); }

std::string VerdictSection(const Verdict& verdict) {
  std::string html = fmt::format(
      "<div class=\"verdict {0}\"><h2>Verdict: {0}</h2>\n", verdict.word);
  if (!verdict.reasons.empty()) html += "<ul>\n";
  for (const std::string& reason : verdict.reasons)
    html += fmt::format("<li>{}</li>\n", EscapeHtml(reason));
  if (!verdict.reasons.empty()) html += "</ul>\n";
  return html + "</div>\n";
}

// ---- Errors ----------------------------------------------------------------

const HtmlRow kErrorHead = {"", "median px", "RMS px", "largest px",
                            "features"};

HtmlRow FiguresRow(const std::string& name, const ErrorFigures& figures) {
  return {name, Px(figures.median_px), Px(figures.rms_px),
          fmt::format("{:.3f}", figures.max_px), std::to_string(figures.count)};
}

std::string ErrorSection(const CalibrationResult& result) {
  std::vector<HtmlRow> rows = {FiguresRow("training", *result.camera.training)};
  if (result.camera.held_out)
    rows.push_back(FiguresRow(result.cross_validated
                                  ? "held out (cross-validation)"
                                  : "held out (images not used)",
                              *result.camera.held_out));
  std::string html =
      "<h2>Reprojection error</h2>\n" + HtmlTable(kErrorHead, rows);
  if (result.camera.held_out)
    html +=
        "<p>A camera that fits its own images proves little: the held-out "
        "error, of images that it has not seen, is what to go by.</p>\n";
  if (result.bias_kl && result.noise_bias_kl)
    html += fmt::format(
        "<p>Bias: Kullback&ndash;Leibler divergence of residuals from a normal "
        "distribution, median of 50 &times; 50 cells: <b>{:.3f}</b>; pure "
        "noise in the same places would have <b>{:.3f}</b>.</p>\n",
        *result.bias_kl, *result.noise_bias_kl);
  return html +
         "<figure class=\"script\"><figcaption>Share of features with no "
         "larger error</figcaption><div class=\"chart\"><canvas "
         "id=\"distribution\"></canvas></div></figure>\n";
}

std::string Optional(const std::optional<double>& value, const char* format) {
  return value ? fmt::format(fmt::runtime(format), *value) : "&ndash;";
}

const HtmlRow kModelHead = {"",
                            "parameters",
                            "training median px",
                            "held-out median px",
                            "held-out RMS px",
                            "bias KL"};

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

std::string ComparisonSection(const CalibrationResult& result) {
  if (result.parametric_models.empty()) return "";
  std::vector<HtmlRow> rows = {ModelRow(
      "<b>" + result.camera.camera->Name() + "</b>", result.num_parameters,
      *result.camera.training, result.camera.held_out, result.bias_kl)};
  for (const ModelFigures& other : result.parametric_models)
    rows.push_back(ModelRow(other.model, other.num_parameters, other.training,
                            other.held_out, other.bias_kl));
  if (result.noise_bias_kl)
    rows.push_back({"pure noise", "", "", "", "",
                    fmt::format("{:.3f}", *result.noise_bias_kl)});
  return "<h2>Other models, from the same features</h2>\n" +
         HtmlTable(kModelHead, rows);
}

std::string CandidateSection(const CalibrationResult& result) {
  if (result.cell_candidates.size() < 2) return "";
  std::vector<HtmlRow> rows;
  for (const CellCandidate& candidate : result.cell_candidates)
    rows.push_back(
        {fmt::format("{:.1f}{}", candidate.cell_px,
                     candidate.cell_px == result.cell_px ? " (chosen)" : ""),
         Px(candidate.median_px), fmt::format("{:.5f}", candidate.loss)});
  return "<h2>Grid resolutions tried</h2>\n" +
         HtmlTable({"cell px", "held-out median px", "held-out loss px&sup2;"},
                   rows);
}

// ---- Camera ----------------------------------------------------------------

void AddTrustRows(const CalibrationResult& result, std::vector<HtmlRow>* rows) {
  const CameraModel& camera = *result.camera.camera;
  if (const auto& known = result.camera.uncertainty) {
    rows->push_back({"standard deviation of the projection",
                     Px(known->lattice.MedianPx()) + " px (median)"});
    rows->push_back(
        {"trusted", fmt::format("{:.0f} % of the image, to {:.4f} px",
                                100 * known->TrustedPart(camera.image_size(),
                                                         camera.area()),
                                known->max_deviation_px)});
  }
  if (result.line_spread)
    rows->push_back({"lines pass the point nearest to all by",
                     fmt::format("{:.3f} mm (RMS), {:.3f} mm (largest)",
                                 1000 * result.line_spread->rms_m,
                                 1000 * result.line_spread->max_m)});
}

void AddPackingRows(const PackingFigures& packing, std::vector<HtmlRow>* rows) {
  rows->push_back({"blob", fmt::format("{} bytes", packing.blob_bytes)});
  rows->push_back({"un-projection error added by packing",
                   fmt::format("{:.2g} px", packing.unproject_error_px)});
  if (packing.remap_error_px)
    rows->push_back({"remap geometry error",
                     fmt::format("{:.3f} px", *packing.remap_error_px)});
}

std::string CameraSection(const CalibrationResult& result,
                          const std::optional<PackingFigures>& packing) {
  const CameraModel& camera = *result.camera.camera;
  const Area& area = camera.area();
  std::vector<HtmlRow> rows = {
      {"model", camera.Name()},
      {"parameters", std::to_string(result.num_parameters)}};
  if (result.cell_px > 0)
    rows.push_back({"cells", fmt::format("at most {:.1f} px", result.cell_px)});
  rows.push_back(
      {"image", fmt::format("{} &times; {} px", camera.image_size().width,
                            camera.image_size().height)});
  rows.push_back(
      {"calibrated area", fmt::format("x {:.1f} to {:.1f}, y {:.1f} to {:.1f}",
                                      area.x0, area.x1, area.y0, area.y1)});
  rows.push_back(
      {"images used", std::to_string(result.features.images.size())});
  if (result.measured_again_rms_px)
    rows.push_back({"features measured again moved by",
                    Px(*result.measured_again_rms_px) + " px (RMS)"});
  if (result.neighbor_correlation)
    rows.push_back({"correlation of neighbouring features' errors",
                    fmt::format("{:.2f}", *result.neighbor_correlation)});
  AddTrustRows(result, &rows);
  if (packing) AddPackingRows(*packing, &rows);
  return "<h2>Camera</h2>\n" + HtmlTable({}, rows);
}

std::string GridSection(const CalibrationResult& result) {
  if (result.cell_px <= 0) return "";
  return "<div class=\"script\"><h2>The grid</h2>\n<figure><figcaption>Control "
         "points over the image; a spline between them gives each pixel its "
         "direction. <span class=\"key seen\"></span> features depend on it "
         "<span class=\"key few\"></span> fewer than 3 <span class=\"key "
         "unseen\"></span> none: smoothness alone holds "
         "it</figcaption><canvas id=\"grid\"></canvas></figure></div>\n";
}

// ---- Pictures --------------------------------------------------------------

PictureAxes ImageAxes(double width, double height) {
  return {
      "x, px",
      "y, px",
      {"0", fmt::format("{:.0f}", width / 2), fmt::format("{:.0f}", width)},
      {"0", fmt::format("{:.0f}", height / 2), fmt::format("{:.0f}", height)}};
}

PictureAxes AreaAxes(const Area& area) {
  const auto ticks = [](double a, double b) -> std::vector<std::string> {
    return {fmt::format("{}", std::lround(a)),
            fmt::format("{}", std::lround((a + b) / 2)),
            fmt::format("{}", std::lround(b))};
  };
  return {"x, px", "y, px", ticks(area.x0, area.x1), ticks(area.y0, area.y1)};
}

// What pictures are made of, in their pixels.
struct PictureSpace {
  double scale = 1;  // picture / image
  ImageSize size;
  Area area;
  std::vector<FeatureResidual> residuals;
};

PictureSpace ShrinkToPicture(const CalibrationResult& result) {
  const CameraModel& camera = *result.camera.camera;
  PictureSpace space;
  space.size = camera.image_size();
  space.area = camera.area();
  space.residuals = result.training;
  if (space.size.width <= kPictureWidthPx) return space;
  space.scale = static_cast<double>(kPictureWidthPx) / space.size.width;
  const auto shrunk = [&space](double position) {
    return (position + 0.5) * space.scale - 0.5;
  };
  space.size = {kPictureWidthPx,
                std::max(1, static_cast<int>(space.size.height * space.scale))};
  space.area = {shrunk(space.area.x0), shrunk(space.area.y0),
                shrunk(space.area.x1), shrunk(space.area.y1)};
  for (FeatureResidual& residual : space.residuals)
    residual.pixel = {shrunk(residual.pixel.x()), shrunk(residual.pixel.y())};
  return space;
}

std::string ResidualPictures(const CalibrationResult& result) {
  const PictureSpace space = ShrinkToPicture(result);
  const ImageSize& size = result.camera.camera->image_size();
  const PictureAxes axes = ImageAxes(size.width, size.height);
  const double full_scale_px =
      std::max(3 * result.camera.training->median_px, 1e-6);
  const std::string wheel =
      "<div class=\"wheel\">" +
      HtmlImage(DirectionLegend(96), "Colours of the directions") +
      "<em>colour: direction of projected &minus; observed, as seen in the "
      "image (right is +x, down is +y)</em></div>";
  return HtmlPicture(CoveragePicture(space.residuals, space.size, space.area),
                     "Coverage: features used (green), and the calibrated area "
                     "(lighter)",
                     axes, "", "image") +
         HtmlPicture(
             DirectionPicture(space.residuals, space.size, space.area),
             "Direction of the nearest residual: patches of one colour show "
             "that the model does not follow the lens",
             axes, wheel, "image") +
         HtmlPicture(MagnitudePicture(space.residuals, space.size, space.area,
                                      full_scale_px),
                     "Size of the nearest residual", axes,
                     HtmlColorBar({ColorScale::kMagnitude, "residual", "0",
                                   fmt::format("{:.3g} px +", full_scale_px)}),
                     "image");
}

std::string BiasFigure(const CalibrationResult& result) {
  if (!result.bias_kl || !result.noise_bias_kl) return "";
  const double full_scale = 3 * *result.noise_bias_kl;
  const Area& area = result.camera.camera->area();
  return HtmlPicture(
      BiasPicture(result.training, area, full_scale),
      "Bias by place: divergence of residuals from noise (white: fewer than 5)",
      AreaAxes(area),
      HtmlColorBar({ColorScale::kEven,
                    fmt::format("KL divergence; the median of noise is {:.2f}",
                                *result.noise_bias_kl),
                    "0", fmt::format("{:.2f} +", full_scale)}),
      "area");
}

// Counts of errors by dx and dy.
std::string HistogramFigure(const std::vector<FeatureResidual>& residuals,
                            const std::string& name, double extent_px) {
  constexpr int kBins = 61;
  if (residuals.empty()) return "";
  std::vector<double> counts(kBins * kBins, 0);
  for (const FeatureResidual& residual : residuals) {
    const Eigen::Vector2d at =
        (residual.error_px / extent_px + Eigen::Vector2d::Ones()) * kBins / 2;
    if ((at.array() >= 0).all() && (at.array() < kBins).all())
      ++counts[static_cast<int>(at.y()) * kBins + static_cast<int>(at.x())];
  }
  const double most = *std::max_element(counts.begin(), counts.end());
  const std::vector<std::string> ticks = {
      fmt::format("{:.3g}", -extent_px), "0", fmt::format("{:.3g}", extent_px)};
  return HtmlPicture(
      HeatMap(counts, kBins, 0, std::max(most, 1.0), 5),
      "Errors of " + name + " features: round and centred if noise",
      {"dx, px", "dy, px", ticks, ticks},
      HtmlColorBar({ColorScale::kEven, "features in a bin", "0",
                    fmt::format("{:.0f}", most)}),
      "error");
}

std::string Histograms(const CalibrationResult& result) {
  const double extent_px =
      std::max(5 * result.camera.training->median_px, 1e-6);
  return HistogramFigure(result.training, "training", extent_px) +
         HistogramFigure(result.held_out, "held-out", extent_px);
}

std::string UncertaintyFigure(const CalibrationResult& result) {
  if (!result.camera.uncertainty) return "";
  const CameraModel& camera = *result.camera.camera;
  return "<figure class=\"wide\"><figcaption>How well the camera is known, by "
         "its features' noise</figcaption>" +
         HtmlImage(UncertaintyPicture(*result.camera.uncertainty,
                                      camera.image_size(), camera.area()),
                   "How well the camera is known") +
         "</figure>\n";
}

std::string PicturesSection(const CalibrationResult& result) {
  return "<h2>Coverage and residuals</h2>\n<div class=\"pictures\">\n" +
         ResidualPictures(result) + BiasFigure(result) + Histograms(result) +
         UncertaintyFigure(result) + "</div>\n";
}

// ---- Lines that do not meet ------------------------------------------------

struct LineOffsets {
  std::vector<double> distance_mm, x_mm, y_mm;
  double max_mm = 1e-9;
};

LineOffsets MeasureOffsets(const CameraModel& camera, int columns, int rows) {
  const Eigen::Vector3d center = MeasureLineSpread(camera).nearest_point;
  const Area& area = camera.area();
  LineOffsets offsets;
  for (int k = 0; k < columns * rows; ++k) {
    const auto line =
        camera.Line({area.x0 + area.width() * (k % columns + 0.5) / columns,
                     area.y0 + area.height() * (k / columns + 0.5) / rows});
    Eigen::Vector3d offset = Eigen::Vector3d::Constant(NAN);
    if (line) {
      const Eigen::Vector3d from = line->origin - center;
      offset = 1000 * (from - line->direction * line->direction.dot(from));
      offsets.max_mm = std::max(offsets.max_mm, offset.norm());
    }
    offsets.distance_mm.push_back(offset.norm());
    offsets.x_mm.push_back(offset.x());
    offsets.y_mm.push_back(offset.y());
  }
  return offsets;
}

std::string LinesSection(const CalibrationResult& result) {
  const CameraModel& camera = *result.camera.camera;
  if (camera.IsCentral()) return "";
  constexpr int kColumns = 64, kRows = 48, kCellPx = 8;
  const LineOffsets offsets = MeasureOffsets(camera, kColumns, kRows);
  const PictureAxes axes = AreaAxes(camera.area());
  const auto picture = [&](const std::vector<double>& values, double low,
                           const std::string& caption) {
    return HtmlPicture(
        HeatMap(values, kColumns, low, offsets.max_mm, kCellPx), caption, axes,
        HtmlColorBar({ColorScale::kEven, "offset", fmt::format("{:.3g}", low),
                      fmt::format("{:.3g} mm", offsets.max_mm)}),
        "area");
  };
  return "<h2>Lines that do not meet in a point</h2>\n<p>How each pixel's line "
         "passes the point that is nearest to all.</p>\n<div "
         "class=\"pictures\">\n" +
         picture(offsets.distance_mm, 0, "Distance from the point") +
         picture(offsets.x_mm, -offsets.max_mm, "Offset to the right (x)") +
         picture(offsets.y_mm, -offsets.max_mm, "Offset downwards (y)") +
         "<figure class=\"script\"><figcaption>Distance against the angle from "
         "the camera's z axis</figcaption><div class=\"chart\"><canvas "
         "id=\"lines\"></canvas></div></figure>\n</div>\n";
}

// ---- Boards ----------------------------------------------------------------

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

std::string BoardSection(const Pattern& pattern) {
  std::string html =
      "<h2>How flat the board is</h2>\n<div class=\"pictures\">\n";
  for (const Board& board : pattern.boards)
    html += BoardFigure(board, MeasureBoardShape(board));
  return html + "</div>\n";
}

std::string SpaceSection() {
  return "<div class=\"script\"><h2>Cameras and boards in space</h2>\n"
         "<figure><figcaption>Drag to turn, wheel or pinch to zoom. Axes of "
         "the "
         "first camera: x right, y down, z forward; <span "
         "id=\"space-scale\"></span></figcaption><canvas "
         "id=\"space\"></canvas></figure></div>\n";
}

// ---- Images ----------------------------------------------------------------

std::map<std::string, std::vector<double>> NormsByImage(
    const std::vector<FeatureResidual>& residuals) {
  std::map<std::string, std::vector<double>> norms;
  for (const FeatureResidual& residual : residuals)
    norms[residual.image].push_back(residual.error_px.norm());
  return norms;
}

// Without the script, and on paper, a table says what the bars do.
std::string ImageTable(const CalibrationResult& result) {
  auto training = NormsByImage(result.training);
  auto held_out = NormsByImage(result.held_out);
  std::map<std::string, HtmlRow> rows;
  for (const auto* norms : {&training, &held_out})
    for (const auto& [image, values] : *norms)
      rows[image] = {EscapeHtml(image), "&ndash;", "&ndash;"};
  for (const auto& [image, values] : training)
    rows[image][1] = Px(Quantile(values, 0.5));
  for (const auto& [image, values] : held_out)
    rows[image][2] = Px(Quantile(values, 0.5));
  std::vector<HtmlRow> list;
  for (const auto& [image, row] : rows) list.push_back(row);
  return "<details><summary>As a table</summary>\n" +
         HtmlTable({"image", "training median px", "held-out median px"},
                   list) +
         "</details>\n";
}

std::string ImagesSection(const CalibrationResult& result) {
  return "<h2>Error by image</h2>\n<div class=\"script\"><p>Choose an image by "
         "its bar to see its residuals.</p>\n"
         "<div class=\"chart\"><canvas id=\"bars\"></canvas></div>\n"
         "<p><button id=\"previous\">&larr;</button> <select "
         "id=\"image\" aria-label=\"image\"></select> <button "
         "id=\"next\">&rarr;</button> <span id=\"image-figures\"></span></p>\n"
         "<figure><figcaption>Residuals, enlarged <span "
         "id=\"enlarged\"></span> times: <span class=\"key "
         "training\"></span> training <span class=\"key held\"></span> held "
         "out <span class=\"key rejected\"></span> taken out "
         "(crosses)</figcaption><canvas "
         "id=\"arrows\"></canvas></figure></div>\n" +
         ImageTable(result);
}

std::string RejectedSection(const CalibrationResult& result) {
  constexpr size_t kMaxLines = 300;
  std::string html;
  if (!result.rejected_images.empty()) {
    html += "<h2>Images not used</h2>\n<ul>\n";
    for (const RejectedImage& image : result.rejected_images)
      html += fmt::format("<li>{}: {}</li>\n", EscapeHtml(image.image),
                          EscapeHtml(image.reason));
    html += "</ul>\n";
  }
  if (result.rejected_features.empty()) return html;
  html += fmt::format("<h2>Features taken out as outliers: {}</h2>\n<ul>\n",
                      result.rejected_features.size());
  std::vector<const FeatureResidual*> worst;
  for (const FeatureResidual& feature : result.rejected_features)
    worst.push_back(&feature);
  std::stable_sort(worst.begin(), worst.end(), [](auto* a, auto* b) {
    return a->error_px.squaredNorm() > b->error_px.squaredNorm();
  });
  for (size_t i = 0; i < std::min(worst.size(), kMaxLines); ++i)
    html +=
        fmt::format("<li>{}, board {}, ({}, {}): {:.2f} px off</li>\n",
                    EscapeHtml(worst[i]->image), worst[i]->board,
                    worst[i]->column, worst[i]->row, worst[i]->error_px.norm());
  html += "</ul>\n";
  if (worst.size() > kMaxLines)
    html += fmt::format("<p>The {} worst; all are in residuals.csv.</p>\n",
                        kMaxLines);
  return html;
}

std::string ExampleSection(const BeforeAfter& example) {
  return "<h2>Before and after</h2>\n<div class=\"pictures\">\n"
         "<figure><figcaption>As taken</figcaption>" +
         HtmlImage(example.before, "As taken") +
         "</figure>\n<figure><figcaption>Undistorted by the runtime; black "
         "where the camera is not calibrated</figcaption>" +
         HtmlImage(example.after, "Undistorted by the runtime") +
         "</figure>\n</div>\n";
}

// ---- Rig -------------------------------------------------------------------

std::string CamerasTable(const RigResult& result) {
  std::vector<HtmlRow> rows;
  for (const CalibrationResult& camera : result.cameras) {
    const std::string name = EscapeHtml(camera.camera.name);
    const ImageSize& size = camera.camera.camera->image_size();
    rows.push_back({fmt::format("<a href=\"{0}/report.html\">{0}</a>", name),
                    camera.verdict.word, camera.camera.camera->Name(),
                    std::to_string(camera.num_parameters),
                    std::to_string(camera.features.images.size()),
                    fmt::format("{} &times; {}", size.width, size.height)});
  }
  return "<h2>Cameras</h2>\n" +
         HtmlTable({"", "verdict", "model", "parameters", "images", "image px"},
                   rows);
}

std::string RigErrorTable(const RigResult& result) {
  const std::string by =
      result.cross_validated ? "cross-validation" : "instants not used";
  std::vector<HtmlRow> rows;
  for (size_t c = 0; c < result.cameras.size(); ++c) {
    const CalibrationResult& camera = result.cameras[c];
    const std::string name = EscapeHtml(camera.camera.name);
    rows.push_back(FiguresRow(name + ", training", *camera.camera.training));
    if (camera.camera.held_out)
      rows.push_back(FiguresRow(name + ", held out, localised alone",
                                *camera.camera.held_out));
    if (c < result.held_out.size() && !result.held_out[c].empty())
      rows.push_back(FiguresRow(name + ", held out, localised by the rig",
                                ComputeErrorFigures(result.held_out[c])));
  }
  rows.push_back(FiguresRow("all, training", TrainingFigures(result)));
  if (const auto held_out = HeldOutFigures(result))
    rows.push_back(FiguresRow(
        "all, held out (" + by + "), localised by the rig", *held_out));
  return "<h2>Reprojection error</h2>\n" + HtmlTable(kErrorHead, rows);
}

// Of each camera, in its own images.
std::string RigComparisonTable(const RigResult& result) {
  std::vector<HtmlRow> rows;
  for (const CalibrationResult& camera : result.cameras) {
    if (camera.parametric_models.empty()) continue;
    const std::string name = EscapeHtml(camera.camera.name) + ", ";
    rows.push_back(
        ModelRow(name + "<b>" + camera.camera.camera->Name() + "</b>",
                 camera.num_parameters, *camera.camera.training,
                 camera.camera.held_out, camera.bias_kl));
    for (const ModelFigures& other : camera.parametric_models)
      rows.push_back(ModelRow(name + other.model, other.num_parameters,
                              other.training, other.held_out, other.bias_kl));
    if (camera.noise_bias_kl)
      rows.push_back({name + "pure noise", "", "", "", "",
                      fmt::format("{:.3f}", *camera.noise_bias_kl)});
  }
  if (rows.empty()) return "";
  return "<h2>Other models, from the same features</h2>\n" +
         HtmlTable(kModelHead, rows) +
         "<p>The other models are those of each camera alone, and held-out "
         "images are localised by it alone.</p>\n";
}

std::string WithDeviation(double value, const std::optional<double>& deviation,
                          double scale) {
  return deviation ? fmt::format("{:.4f} &plusmn; {:.4f}", value * scale,
                                 *deviation * scale)
                   : fmt::format("{:.4f}", value * scale);
}

std::string BaselineTable(const RigResult& result) {
  std::vector<HtmlRow> rows;
  for (const Baseline& baseline : result.baselines)
    rows.push_back(
        {fmt::format("{} to {}",
                     EscapeHtml(result.cameras[baseline.first].camera.name),
                     EscapeHtml(result.cameras[baseline.second].camera.name)),
         WithDeviation(baseline.distance_m, baseline.distance_sd_m, 1000),
         WithDeviation(baseline.angle_rad, baseline.rotation_sd_rad,
                       180 / M_PI),
         std::to_string(baseline.num_shared_views)});
  return "<h2>How the cameras stand to each other</h2>\n" +
         HtmlTable({"", "distance mm", "angle degrees", "boards seen by both"},
                   rows);
}

}  // namespace

std::string FormatHtmlReport(const CalibrationResult& result,
                             const std::optional<PackingFigures>& packing,
                             const std::optional<BeforeAfter>& example,
                             const ThumbnailTexts& thumbnails) {
  const std::string name =
      result.camera.name.empty() ? "" : ": " + EscapeHtml(result.camera.name);
  std::string html = PageStart("Camera calibration" + name);
  html += VerdictSection(result.verdict);
  html += ErrorSection(result);
  html += ComparisonSection(result);
  html += PicturesSection(result);
  html += ImagesSection(result);
  if (example) html += ExampleSection(*example);
  html += CameraSection(result, packing);
  html += GridSection(result);
  html += LinesSection(result);
  html += SpaceSection();
  html += BoardSection(result.pattern);
  html += CandidateSection(result);
  html += RejectedSection(result);
  return html + PageEnd(PageData(result, thumbnails));
}

std::string FormatRigReport(const RigResult& result) {
  return PageStart("Rig calibration") + VerdictSection(result.verdict) +
         CamerasTable(result) + RigErrorTable(result) +
         RigComparisonTable(result) + BaselineTable(result) + SpaceSection() +
         BoardSection(result.pattern) + PageEnd(PageData(result));
}

}  // namespace raygrid
