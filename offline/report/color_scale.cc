#include "report/color_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace raygrid {
namespace {

constexpr std::array<uint8_t, 3> kNoDataColor = {255, 255, 255};

cv::Mat MakeTable(int map) {
  cv::Mat grey(1, 256, CV_8U), bgr;
  for (int i = 0; i < 256; ++i)
    grey.at<uint8_t>(0, i) = static_cast<uint8_t>(i);
  cv::applyColorMap(grey, bgr, map);
  return bgr;
}

const cv::Mat& GetColorTable(ColorScale scale) {
  static const cv::Mat magnitude = MakeTable(cv::COLORMAP_INFERNO);
  static const cv::Mat even = MakeTable(cv::COLORMAP_CIVIDIS);
  static const cv::Mat direction = MakeTable(cv::COLORMAP_TWILIGHT);
  switch (scale) {
    case ColorScale::kMagnitude:
      return magnitude;
    case ColorScale::kDirection:
      return direction;
    default:
      return even;
  }
}

}  // namespace

std::array<uint8_t, 3> GetColor(ColorScale scale, double part) {
  const long index = std::clamp(std::lround(255 * part), 0L, 255L);
  const auto color =
      GetColorTable(scale).at<cv::Vec3b>(0, static_cast<int>(index));
  return {color[0], color[1], color[2]};
}

std::string CssGradient(ColorScale scale) {
  constexpr int kStops = 17;
  std::string css = "linear-gradient(to right";
  for (int k = 0; k < kStops; ++k) {
    const auto color = GetColor(scale, double(k) / (kStops - 1));
    css += fmt::format(",#{:02x}{:02x}{:02x}", color[2], color[1], color[0]);
  }
  return css + ")";
}

Image HeatMap(const std::vector<double>& values, int columns, double low,
              double high, int knot_spacing_px, ColorScale scale) {
  const int rows = static_cast<int>(values.size()) / columns;
  Image image;
  image.size = {columns * knot_spacing_px, rows * knot_spacing_px};
  image.channels = 3;
  for (int y = 0; y < image.size.height; ++y) {
    for (int x = 0; x < image.size.width; ++x) {
      const double value =
          values[y / knot_spacing_px * columns + x / knot_spacing_px];
      const auto color = std::isfinite(value)
                             ? GetColor(scale, (value - low) / (high - low))
                             : kNoDataColor;
      image.pixels.insert(image.pixels.end(), color.begin(), color.end());
    }
  }
  return image;
}

}  // namespace raygrid
