#include "report/plot_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/html.h"
#include "report/plots.h"
#include "report/uncertainty_plot.h"

namespace raygrid {
namespace {

constexpr int kPlotWidthPx = 800;

HtmlImageAxes ImageAxes(double width, double height) {
  return {
      "x, px",
      "y, px",
      {"0", fmt::format("{:.0f}", width / 2), fmt::format("{:.0f}", width)},
      {"0", fmt::format("{:.0f}", height / 2), fmt::format("{:.0f}", height)}};
}

// The dataset in the pixel coordinates of a picture.
struct PlotData {
  double scale = 1;  // picture pixels per image pixel
  ImageSize size;
  Area area;
  std::vector<FeatureResidual> residuals;
};

PlotData ScaleToPlot(const CalibrationResult& result) {
  const CameraModel& camera = *result.camera.camera;
  PlotData space;
  space.size = camera.image_size();
  space.area = camera.area();
  space.residuals = result.training;
  if (space.size.width <= kPlotWidthPx) return space;
  space.scale = static_cast<double>(kPlotWidthPx) / space.size.width;
  const auto shrunk = [&space](double position) {
    return (position + 0.5) * space.scale - 0.5;
  };
  space.size = {kPlotWidthPx,
                std::max(1, static_cast<int>(space.size.height * space.scale))};
  space.area = {shrunk(space.area.x0), shrunk(space.area.y0),
                shrunk(space.area.x1), shrunk(space.area.y1)};
  for (FeatureResidual& residual : space.residuals)
    residual.pixel = {shrunk(residual.pixel.x()), shrunk(residual.pixel.y())};
  return space;
}

std::string MakeResidualPlots(const CalibrationResult& result) {
  const PlotData space = ScaleToPlot(result);
  const ImageSize& size = result.camera.camera->image_size();
  const HtmlImageAxes axes = ImageAxes(size.width, size.height);
  const double full_scale_px =
      std::max(3 * result.camera.training->median_px, 1e-6);
  const std::string wheel =
      "<div class=\"wheel\">" +
      MakeHtmlImage(DrawDirectionLegend(96), "Colours of the directions") +
      "<em>colour: direction of projected &minus; observed, as seen in the "
      "image (right is +x, down is +y)</em></div>";
  return EmbedHtmlImage(
             DrawCoveragePlot(space.residuals, space.size, space.area),
             "Coverage: features used (green) and calibrated area (lighter)",
             axes, "", "image") +
         EmbedHtmlImage(
             DrawDirectionPlot(space.residuals, space.size, space.area),
             "Direction of the nearest residual: patches of one colour "
             "indicate model error",
             axes, wheel, "image") +
         EmbedHtmlImage(
             DrawMagnitudePlot(space.residuals, space.size, space.area,
                               full_scale_px),
             "Magnitude of the nearest residual", axes,
             MakeHtmlColorBar({ColorScale::kMagnitude, "residual", "0",
                               fmt::format("{:.3g} px +", full_scale_px)}),
             "image");
}

std::string MakeBiasPlot(const CalibrationResult& result) {
  if (!result.bias_kl || !result.noise_bias_kl) return "";
  const double full_scale = 3 * *result.noise_bias_kl;
  const Area& area = result.camera.camera->area();
  return EmbedHtmlImage(
      DrawBiasPlot(result.training, area, full_scale),
      "Bias over the image: divergence of residuals from noise (white: fewer "
      "than 5 features)",
      AreaAxes(area),
      MakeHtmlColorBar(
          {ColorScale::kEven,
           fmt::format("KL divergence; median for white noise {:.2f}",
                       *result.noise_bias_kl),
           "0", fmt::format("{:.2f} +", full_scale)}),
      "area");
}

// Returns a histogram of residuals by dx and dy.
std::string MakeHistogramFigure(const std::vector<FeatureResidual>& residuals,
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
  return EmbedHtmlImage(
      HeatMap(counts, kBins, 0, std::max(most, 1.0), 5),
      "Residuals of " + name + " features: round and centred for noise",
      {"dx, px", "dy, px", ticks, ticks},
      MakeHtmlColorBar({ColorScale::kEven, "features per bin", "0",
                        fmt::format("{:.0f}", most)}),
      "error");
}

std::string Histograms(const CalibrationResult& result) {
  const double extent_px =
      std::max(5 * result.camera.training->median_px, 1e-6);
  return MakeHistogramFigure(result.training, "training", extent_px) +
         MakeHistogramFigure(result.held_out, "held-out", extent_px);
}

std::string MakeUncertaintyFigure(const CalibrationResult& result) {
  if (!result.camera.uncertainty) return "";
  const CameraModel& camera = *result.camera.camera;
  return "<figure class=\"wide\"><figcaption>Predicted "
         "uncertainty</figcaption>" +
         MakeHtmlImage(DrawUncertaintyPlot(*result.camera.uncertainty,
                                           camera.image_size(), camera.area()),
                       "Predicted uncertainty") +
         "</figure>\n";
}

// ---- Non-central cameras ---------------------------------------------------

struct LineOffsets {
  std::vector<double> distance_mm, x_mm, y_mm;
  double max_offset_mm = 1e-9;
};

LineOffsets MeasureOffsets(const CameraModel& camera, int columns, int rows) {
  const Eigen::Vector3d center = ComputeNoncentrality(camera).nearest_point;
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
      offsets.max_offset_mm = std::max(offsets.max_offset_mm, offset.norm());
    }
    offsets.distance_mm.push_back(offset.norm());
    offsets.x_mm.push_back(offset.x());
    offsets.y_mm.push_back(offset.y());
  }
  return offsets;
}

}  // namespace

std::string MakePlotsSection(const CalibrationResult& result) {
  return "<h2>Coverage and residuals</h2>\n<div class=\"pictures\">\n" +
         MakeResidualPlots(result) + MakeBiasPlot(result) + Histograms(result) +
         MakeUncertaintyFigure(result) + "</div>\n";
}

std::string MakeLinesSection(const CalibrationResult& result) {
  const CameraModel& camera = *result.camera.camera;
  if (camera.IsCentral()) return "";
  constexpr int kColumns = 64, kRows = 48, kCellPx = 8;
  const LineOffsets offsets = MeasureOffsets(camera, kColumns, kRows);
  const HtmlImageAxes axes = AreaAxes(camera.area());
  const auto picture = [&](const std::vector<double>& values, double low,
                           const std::string& caption) {
    return EmbedHtmlImage(
        HeatMap(values, kColumns, low, offsets.max_offset_mm, kCellPx), caption,
        axes,
        MakeHtmlColorBar({ColorScale::kEven, "offset",
                          fmt::format("{:.3g}", low),
                          fmt::format("{:.3g} mm", offsets.max_offset_mm)}),
        "area");
  };
  return "<h2>Non-central observation lines</h2>\n<p>Offset of each pixel's "
         "observation line from the common point.</p>\n<div "
         "class=\"pictures\">\n" +
         picture(offsets.distance_mm, 0, "Distance from the common point") +
         picture(offsets.x_mm, -offsets.max_offset_mm,
                 "Offset to the right (x)") +
         picture(offsets.y_mm, -offsets.max_offset_mm, "Offset downwards (y)") +
         "<figure class=\"script\"><figcaption>Distance against the angle from "
         "the camera's z axis</figcaption><div class=\"chart\"><canvas "
         "id=\"lines\"></canvas></div></figure>\n</div>\n";
}

}  // namespace raygrid
