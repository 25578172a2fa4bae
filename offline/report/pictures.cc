#include "report/pictures.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>

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

// 180 hues around the circle.
cv::Vec3b HueColor(double angle_rad) {
  static const cv::Mat table = [] {
    cv::Mat hsv(1, 180, CV_8UC3), bgr;
    for (int hue = 0; hue < 180; ++hue)
      hsv.at<cv::Vec3b>(0, hue) =
          cv::Vec3b(static_cast<uint8_t>(hue), 220, 230);
    cv::cvtColor(hsv, bgr, cv::COLOR_HSV2BGR);
    return bgr;
  }();
  const double half_degrees = angle_rad * 90 / M_PI;
  const int hue = static_cast<int>(std::lround(half_degrees + 180)) % 180;
  return table.at<cv::Vec3b>(0, hue);
}

// A perceptually even scale from dark to bright.
cv::Vec3b MagnitudeColor(double part) {
  static const cv::Mat table = [] {
    cv::Mat grey(1, 256, CV_8U), bgr;
    for (int i = 0; i < 256; ++i)
      grey.at<uint8_t>(0, i) = static_cast<uint8_t>(i);
    cv::applyColorMap(grey, bgr, cv::COLORMAP_INFERNO);
    return bgr;
  }();
  return table.at<cv::Vec3b>(
      0, static_cast<int>(std::clamp(std::lround(255 * part), 0L, 255L)));
}

cv::Point NearestPixel(const Eigen::Vector2d& position, const ImageSize& size) {
  return {std::clamp(static_cast<int>(std::lround(position.x())), 0,
                     size.width - 1),
          std::clamp(static_cast<int>(std::lround(position.y())), 0,
                     size.height - 1)};
}

// Colours every pixel of the area by the residual nearest to it.
Image VoronoiPicture(
    const std::vector<FeatureResidual>& residuals, const ImageSize& size,
    const Area& area,
    const std::function<cv::Vec3b(const Eigen::Vector2d&)>& color_of) {
  cv::Mat sites(size.height, size.width, CV_8U, cv::Scalar(255));
  for (const FeatureResidual& residual : residuals)
    sites.at<uint8_t>(NearestPixel(residual.pixel, size)) = 0;
  cv::Mat distance, labels;
  cv::distanceTransform(sites, distance, labels, cv::DIST_L2,
                        cv::DIST_MASK_PRECISE, cv::DIST_LABEL_PIXEL);
  std::vector<cv::Vec3b> colors(residuals.size() + 1, kOutside);
  for (const FeatureResidual& residual : residuals)
    colors[labels.at<int>(NearestPixel(residual.pixel, size))] =
        color_of(residual.error_px);
  cv::Mat picture(size.height, size.width, CV_8UC3, kOutside);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      if (!residuals.empty() && area.Contains(Eigen::Vector2d(x, y)))
        picture.at<cv::Vec3b>(y, x) = colors[labels.at<int>(y, x)];
  return ToImage(picture);
}

}  // namespace

Image CoveragePicture(const std::vector<FeatureResidual>& residuals,
                      const ImageSize& size, const Area& area) {
  cv::Mat picture(size.height, size.width, CV_8UC3, cv::Scalar(60, 60, 60));
  cv::rectangle(picture, NearestPixel({area.x0, area.y0}, size),
                NearestPixel({area.x1, area.y1}, size), cv::Scalar(90, 90, 90),
                cv::FILLED);
  const int radius = std::max(2, size.width / 300);
  for (const FeatureResidual& residual : residuals)
    cv::circle(picture, NearestPixel(residual.pixel, size), radius,
               cv::Scalar(120, 220, 120), cv::FILLED, cv::LINE_AA);
  return ToImage(picture);
}

Image DirectionPicture(const std::vector<FeatureResidual>& residuals,
                       const ImageSize& size, const Area& area) {
  return VoronoiPicture(residuals, size, area,
                        [](const Eigen::Vector2d& error) {
                          return HueColor(std::atan2(error.y(), error.x()));
                        });
}

Image MagnitudePicture(const std::vector<FeatureResidual>& residuals,
                       const ImageSize& size, const Area& area,
                       double full_scale_px) {
  return VoronoiPicture(residuals, size, area,
                        [full_scale_px](const Eigen::Vector2d& error) {
                          return MagnitudeColor(error.norm() / full_scale_px);
                        });
}

Image DirectionLegend(int size_px) {
  cv::Mat picture(size_px, size_px, CV_8UC3, kOutside);
  const double center = (size_px - 1) / 2.0;
  for (int y = 0; y < size_px; ++y)
    for (int x = 0; x < size_px; ++x)
      if (std::hypot(x - center, y - center) <= center)
        picture.at<cv::Vec3b>(y, x) =
            HueColor(std::atan2(y - center, x - center));
  return ToImage(picture);
}

}  // namespace raygrid
