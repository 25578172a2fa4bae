#include "report/uncertainty_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "evaluation/residual_statistics.h"
#include "report/axis_ticks.h"
#include "report/color_scale.h"

namespace raygrid {
namespace {

constexpr int kWidth = 800, kLegendHeight = 90, kMargin = 20;
const cv::Vec3b kUnknown(128, 128, 128), kHatch(255, 255, 255);

cv::Vec3b ScaleColor(double part) {
  const auto color = GetColor(ColorScale::kEven, part);
  return {color[0], color[1], color[2]};
}

// The scale covers nearly all of the grid; values in single corners may exceed
// it.
double ComputeFullScalePx(const UncertaintyLattice& lattice) {
  constexpr double kScaleQuantile = 0.9;
  std::vector<double> valid_stddevs;
  for (const double value : lattice.stddev_px)
    if (std::isfinite(value)) valid_stddevs.push_back(value);
  return RoundUp(std::max(Quantile(valid_stddevs, kScaleQuantile), 1e-6));
}

void DrawText(const std::string& text, const cv::Point& left_baseline,
              cv::Mat* picture) {
  cv::putText(*picture, text, left_baseline, cv::FONT_HERSHEY_SIMPLEX, 0.5,
              cv::Scalar(0, 0, 0), 1, cv::LINE_AA);
}

bool IsHatched(int x, int y) { return (x + y) % 12 < 2; }

void DrawScale(double full_scale_px, int top, cv::Mat* picture) {
  constexpr int kBarHeight = 18, kTicks = 5;
  const int length = kWidth - 2 * kMargin;
  for (int x = 0; x < length; ++x)
    picture->col(kMargin + x)
        .rowRange(top, top + kBarHeight)
        .setTo(ScaleColor(static_cast<double>(x) / (length - 1)));
  for (int k = 0; k <= kTicks; ++k) {
    const std::string text = fmt::format("{:.3g}{}", full_scale_px * k / kTicks,
                                         k == kTicks ? " px +" : "");
    DrawText(text,
             {std::min(kMargin + length * k / kTicks, kWidth - 105),
              top + kBarHeight + 18},
             picture);
  }
  DrawText(
      "predicted uncertainty (1 sigma per axis, distant points); hatched: "
      "outside the valid region",
      {kMargin, top + kBarHeight + 40}, picture);
}

}  // namespace

Image DrawUncertaintyPlot(const CameraUncertainty& uncertainty,
                          const ImageSize& size, const Area& area) {
  const double scale = static_cast<double>(kWidth) / size.width;
  const int height = std::max(1, static_cast<int>(size.height * scale));
  const double full_scale_px = ComputeFullScalePx(uncertainty.lattice);
  cv::Mat picture(height + kLegendHeight, kWidth, CV_8UC3,
                  cv::Scalar(255, 255, 255));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Eigen::Vector2d pixel((x + 0.5) / scale - 0.5,
                                  (y + 0.5) / scale - 0.5);
      cv::Vec3b& color = picture.at<cv::Vec3b>(y, x);
      color = kUnknown;
      if (!area.Contains(pixel)) continue;
      const double deviation = uncertainty.lattice.At(area, pixel);
      if (std::isfinite(deviation))
        color = ScaleColor(deviation / full_scale_px);
      if (!uncertainty.mask.IsValidAt(pixel) && IsHatched(x, y)) color = kHatch;
    }
  }
  DrawScale(full_scale_px, height + 16, &picture);
  Image image;
  image.size = {picture.cols, picture.rows};
  image.channels = 3;
  image.pixels.assign(picture.datastart, picture.dataend);
  return image;
}

}  // namespace raygrid
