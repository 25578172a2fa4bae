#include "features/detection_overlays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <tuple>

namespace raygrid {
namespace {

const cv::Scalar kGreen(0, 200, 0), kDarkGreen(0, 130, 0), kRed(0, 0, 255),
    kYellow(0, 220, 255), kWhite(255, 255, 255), kBlack(0, 0, 0);
constexpr int kMinDrawingPx = 1280;  // minimum side of the drawing
constexpr int kShift = 4;            // fractional bits of OpenCV coordinates
constexpr double kFontScale = 0.5;
constexpr int kLineHeightPx = 20;

Image FromMat(const cv::Mat& bgr) {
  Image image;
  image.size = {bgr.cols, bgr.rows};
  image.channels = 3;
  image.pixels.assign(bgr.datastart, bgr.dataend);
  return image;
}

void Write(cv::Mat* canvas, const std::string& text, cv::Point left_baseline,
           const cv::Scalar& color) {
  for (const int thickness : {3, 1})
    cv::putText(*canvas, text, left_baseline, cv::FONT_HERSHEY_SIMPLEX,
                kFontScale, thickness == 1 ? color : kBlack, thickness,
                cv::LINE_AA);
}

// Draws at image coordinates on a canvas enlarged by scale.
class Overlay {
 public:
  explicit Overlay(const GreyImage& image)
      : scale_(
            std::clamp(kMinDrawingPx / std::max(1, image.size.width), 1, 4)) {
    const cv::Mat grey(image.size.height, image.size.width, CV_8U,
                       const_cast<uint8_t*>(image.bytes.data()));
    cv::cvtColor(grey, canvas_, cv::COLOR_GRAY2BGR);
    cv::resize(canvas_, canvas_, cv::Size(), scale_, scale_, cv::INTER_NEAREST);
  }

  void Cross(const Eigen::Vector2d& pixel, const cv::Scalar& color) {
    constexpr double kArmPx = 5;
    for (const Eigen::Vector2d& arm :
         {Eigen::Vector2d(kArmPx, 0), Eigen::Vector2d(0, kArmPx)})
      cv::line(canvas_, Place(pixel, -arm), Place(pixel, arm), color, 1,
               cv::LINE_AA, kShift);
  }
  void Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    cv::line(canvas_, Place(a), Place(b), kDarkGreen, 1, cv::LINE_AA, kShift);
  }
  void Circle(const Eigen::Vector2d& pixel) {
    cv::circle(canvas_, Place(pixel), 9 << kShift, kYellow, 2, cv::LINE_AA,
               kShift);
  }
  void Label(const Eigen::Vector2d& pixel, const std::string& text) {
    const cv::Point p = Place(pixel, {7, 4});
    Write(&canvas_, text, {p.x >> kShift, p.y >> kShift}, kRed);
  }
  void DrawHeading(const std::vector<std::string>& lines) {
    for (size_t i = 0; i < lines.size(); ++i)
      Write(&canvas_, lines[i], {8, static_cast<int>(i + 1) * kLineHeightPx},
            kYellow);
  }
  const cv::Mat& canvas() const { return canvas_; }

 private:
  // The centre of a pixel maps to the centre of the enlarged pixel.
  cv::Point Place(const Eigen::Vector2d& pixel,
                  const Eigen::Vector2d& offset_px = {0, 0}) const {
    const Eigen::Vector2d p =
        ((pixel.array() + 0.5) * scale_ - 0.5).matrix() + offset_px;
    return {static_cast<int>(std::lround(p.x() * (1 << kShift))),
            static_cast<int>(std::lround(p.y() * (1 << kShift)))};
  }

  int scale_;
  cv::Mat canvas_;
};

void DrawFeatureOrder(const std::vector<Feature>& features, Overlay* overlay) {
  std::map<std::tuple<int, int, int>, Eigen::Vector2d> pixel_by_feature;
  for (const Feature& f : features)
    pixel_by_feature[{f.board, f.column, f.row}] = f.pixel;
  for (const Feature& f : features) {
    const auto next = pixel_by_feature.find({f.board, f.column + 1, f.row});
    if (next != pixel_by_feature.end()) overlay->Line(f.pixel, next->second);
  }
}

// Applies a colour map from dark blue (0) to yellow (1).
cv::Mat ApplyColorMap(const cv::Mat& zero_to_one) {
  cv::Mat bytes, colored;
  zero_to_one.convertTo(bytes, CV_8U, 255);
  cv::applyColorMap(bytes, colored, cv::COLORMAP_VIRIDIS);
  return colored;
}

// Returns the feature density: number of features in a square of side_px around
// each pixel of an image scaled by scale.
cv::Mat ComputeFeatureDensity(const Dataset& dataset, double scale,
                              double side_px) {
  const double height = std::round(dataset.image_size.height * scale);
  const double width = std::round(dataset.image_size.width * scale);
  cv::Mat density(std::max(1, static_cast<int>(height)),
                  static_cast<int>(width), CV_32F, cv::Scalar(0));
  for (const ImageFeatures& image : dataset.images) {
    for (const Feature& f : image.features) {
      const int x = static_cast<int>((f.pixel.x() + 0.5) * scale);
      const int y = static_cast<int>((f.pixel.y() + 0.5) * scale);
      if (x >= 0 && y >= 0 && x < density.cols && y < density.rows)
        density.at<float>(y, x) += 1;
    }
  }
  const double sigma = side_px * scale / 3;
  cv::GaussianBlur(density, density, cv::Size(), sigma, sigma,
                   cv::BORDER_REFLECT);
  return density * std::pow(side_px * scale, 2);
}

// Draws the colour bar from 0 to most, with labels.
cv::Mat Scale(int height, double most) {
  cv::Mat column(height, 90, CV_8UC3, kBlack);
  const int top = 30, bottom = height - 20;
  for (int y = top; y < bottom; ++y) {
    const cv::Mat value(1, 1, CV_32F,
                        cv::Scalar(double(bottom - y) / (bottom - top)));
    column(cv::Rect(10, y, 20, 1)) =
        cv::Scalar(ApplyColorMap(value).at<cv::Vec3b>(0));
  }
  Write(&column, fmt::format("{:.3g}", most), {36, top + 6}, kWhite);
  Write(&column, fmt::format("{:.3g}", most / 2), {36, (top + bottom) / 2 + 4},
        kWhite);
  Write(&column, "0", {36, bottom}, kWhite);
  return column;
}

cv::Mat DrawTitle(int width, const std::string& text) {
  cv::Mat row(kLineHeightPx + 10, width, CV_8UC3, kBlack);
  Write(&row, text, {8, kLineHeightPx}, kWhite);
  return row;
}

}  // namespace

Image DrawDetection(const GreyImage& image, const ImageDetection& detection) {
  Overlay overlay(image);
  DrawFeatureOrder(detection.features, &overlay);
  for (const Feature& f : detection.features) {
    overlay.Cross(f.pixel, kGreen);
    if (f.column == 0 && f.row == 0) overlay.Circle(f.pixel);
  }
  for (const RejectedFeature& rejected : detection.rejected) {
    overlay.Cross(rejected.feature.pixel, kRed);
    overlay.Label(rejected.feature.pixel, rejected.reason);
  }
  overlay.DrawHeading(detection.warnings);
  return FromMat(overlay.canvas());
}

Image DrawCoverage(const Dataset& dataset) {
  constexpr double kWidthPx = 800;
  const int width = dataset.image_size.width;
  const double scale = kWidthPx / width;
  const double side_px = width / 16.0;
  const cv::Mat density = ComputeFeatureDensity(dataset, scale, side_px);
  double most = 0;
  cv::minMaxIdx(density, nullptr, &most);
  const cv::Mat heat = ApplyColorMap(density / std::max(most, 1e-9));
  cv::Mat body, picture;
  cv::hconcat(heat, Scale(heat.rows, most), body);
  cv::vconcat(
      DrawTitle(
          body.cols,
          fmt::format("Features per {0:.0f} x {0:.0f} px, sum of {1} images",
                      side_px, dataset.images.size())),
      body, picture);
  return FromMat(picture);
}

}  // namespace raygrid
