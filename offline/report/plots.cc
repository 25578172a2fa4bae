#include "report/plots.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "report/color_scale.h"

namespace raygrid {
namespace {

const cv::Vec3b kOutside(128, 128, 128);

Image ToImage(const cv::Mat& picture) {
  Image image;
  image.size = {picture.cols, picture.rows};
  image.channels = picture.channels();
  image.pixels.assign(picture.datastart, picture.dataend);
  return image;
}

cv::Vec3b ColorAt(ColorScale scale, double part) {
  const auto color = GetColor(scale, part);
  return {color[0], color[1], color[2]};
}

cv::Vec3b DirectionColor(const Eigen::Vector2d& error) {
  const double turn = std::atan2(error.y(), error.x()) / (2 * M_PI);
  return ColorAt(ColorScale::kDirection, turn < 0 ? turn + 1 : turn);
}

cv::Point RoundToPixel(const Eigen::Vector2d& position, const ImageSize& size) {
  return {std::clamp(static_cast<int>(std::lround(position.x())), 0,
                     size.width - 1),
          std::clamp(static_cast<int>(std::lround(position.y())), 0,
                     size.height - 1)};
}

// Colours each pixel of the area by the nearest residual.
Image DrawVoronoiPlot(
    const std::vector<FeatureResidual>& residuals, const ImageSize& size,
    const Area& area,
    const std::function<cv::Vec3b(const Eigen::Vector2d&)>& get_color) {
  cv::Mat sites(size.height, size.width, CV_8U, cv::Scalar(255));
  for (const FeatureResidual& residual : residuals)
    sites.at<uint8_t>(RoundToPixel(residual.pixel, size)) = 0;
  cv::Mat distance, labels;
  cv::distanceTransform(sites, distance, labels, cv::DIST_L2,
                        cv::DIST_MASK_PRECISE, cv::DIST_LABEL_PIXEL);
  std::vector<cv::Vec3b> colors(residuals.size() + 1, kOutside);
  for (const FeatureResidual& residual : residuals)
    colors[labels.at<int>(RoundToPixel(residual.pixel, size))] =
        get_color(residual.error_px);
  cv::Mat picture(size.height, size.width, CV_8UC3, kOutside);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      if (!residuals.empty() && area.Contains(Eigen::Vector2d(x, y)))
        picture.at<cv::Vec3b>(y, x) = colors[labels.at<int>(y, x)];
  return ToImage(picture);
}

}  // namespace

Image DrawCoveragePlot(const std::vector<FeatureResidual>& residuals,
                       const ImageSize& size, const Area& area) {
  cv::Mat picture(size.height, size.width, CV_8UC3, cv::Scalar(60, 60, 60));
  cv::rectangle(picture, RoundToPixel({area.x0, area.y0}, size),
                RoundToPixel({area.x1, area.y1}, size), cv::Scalar(90, 90, 90),
                cv::FILLED);
  const int radius = std::max(2, size.width / 300);
  for (const FeatureResidual& residual : residuals)
    cv::circle(picture, RoundToPixel(residual.pixel, size), radius,
               cv::Scalar(120, 220, 120), cv::FILLED, cv::LINE_AA);
  return ToImage(picture);
}

Image DrawDirectionPlot(const std::vector<FeatureResidual>& residuals,
                        const ImageSize& size, const Area& area) {
  return DrawVoronoiPlot(residuals, size, area, DirectionColor);
}

Image DrawMagnitudePlot(const std::vector<FeatureResidual>& residuals,
                        const ImageSize& size, const Area& area,
                        double full_scale_px) {
  return DrawVoronoiPlot(
      residuals, size, area, [full_scale_px](const Eigen::Vector2d& error) {
        return ColorAt(ColorScale::kMagnitude, error.norm() / full_scale_px);
      });
}

Image DrawDirectionLegend(int size_px) {
  cv::Mat picture(size_px, size_px, CV_8UC3, kOutside);
  const double center = (size_px - 1) / 2.0;
  for (int y = 0; y < size_px; ++y)
    for (int x = 0; x < size_px; ++x)
      if (std::hypot(x - center, y - center) <= center)
        picture.at<cv::Vec3b>(y, x) = DirectionColor({x - center, y - center});
  return ToImage(picture);
}

Image DrawBiasPlot(const std::vector<FeatureResidual>& residuals,
                   const Area& area, double full_scale) {
  constexpr int kCellPx = 8;
  return HeatMap(ComputeCellBias(residuals, area), kBiasCells, 0, full_scale,
                 kCellPx);
}

Image DrawDisplacementPlot(const std::vector<Eigen::Vector2d>& displacements,
                           int columns, double full_scale_px) {
  constexpr int kCellPx = 8, kArrowSpacingCells = 6,
                kApartPx = kCellPx * kArrowSpacingCells;
  std::vector<double> sizes;
  for (const Eigen::Vector2d& displacement : displacements)
    sizes.push_back(displacement.norm());
  Image picture = HeatMap(sizes, columns, 0, full_scale_px, kCellPx);
  cv::Mat drawn(picture.size.height, picture.size.width, CV_8UC3,
                picture.pixels.data());
  const int rows = static_cast<int>(displacements.size()) / columns;
  for (int j = kArrowSpacingCells / 2; j < rows; j += kArrowSpacingCells) {
    for (int i = kArrowSpacingCells / 2; i < columns; i += kArrowSpacingCells) {
      const Eigen::Vector2d arrow =
          displacements[j * columns + i] * kApartPx / full_scale_px;
      if (!arrow.allFinite()) continue;
      const Eigen::Vector2d center(kCellPx * (i + 0.5), kCellPx * (j + 0.5));
      const cv::Point from = RoundToPixel(center - arrow / 2, picture.size);
      const cv::Point to = RoundToPixel(center + arrow / 2, picture.size);
      for (const auto& [color, thickness] :
           {std::pair(cv::Scalar(0, 0, 0), 3),
            std::pair(cv::Scalar(255, 255, 255), 1)})
        cv::arrowedLine(drawn, from, to, color, thickness, cv::LINE_AA, 0, 0.3);
    }
  }
  return picture;
}

Image ShrinkImage(const Image& image, int max_width_px) {
  if (image.size.width <= max_width_px) return image;
  const cv::Mat whole(image.size.height, image.size.width,
                      CV_8UC(image.channels),
                      const_cast<uint8_t*>(image.pixels.data()));
  cv::Mat smaller;
  cv::resize(whole, smaller,
             {max_width_px,
              std::max(1, image.size.height * max_width_px / image.size.width)},
             0, 0, cv::INTER_AREA);
  return ToImage(smaller);
}

}  // namespace raygrid
