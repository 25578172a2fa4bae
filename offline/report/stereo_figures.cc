#include "report/stereo_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "report/color_scale.h"
#include "report/html.h"

namespace raygrid {
namespace {

// Returns a copy of the image, transposed for vertical pairs.
cv::Mat RotateToHorizontal(const Image& image, bool is_vertical) {
  cv::Mat pixels = cv::Mat(image.size.height, image.size.width, CV_8U,
                           const_cast<uint8_t*>(image.pixels.data()))
                       .clone();
  if (is_vertical) cv::transpose(pixels, pixels);
  return pixels;
}

Image ColourImage(const cv::Mat& picture) {
  Image image;
  image.size = {picture.cols, picture.rows};
  image.channels = 3;
  image.pixels.assign(picture.datastart, picture.dataend);
  return image;
}

}  // namespace

Image DrawRectifiedRows(const RectifiedImages& images) {
  constexpr int kNumRows = 16;
  cv::Mat both, picture;
  cv::hconcat(RotateToHorizontal(images.first, images.is_vertical),
              RotateToHorizontal(images.second, images.is_vertical), both);
  cv::cvtColor(both, picture, cv::COLOR_GRAY2BGR);
  const cv::Scalar colours[] = {{60, 220, 60}, {40, 170, 255}};
  for (int k = 0; k < kNumRows; ++k) {
    const int row = (2 * k + 1) * picture.rows / (2 * kNumRows);
    cv::line(picture, {0, row}, {picture.cols - 1, row}, colours[k % 2]);
  }
  cv::line(picture, {picture.cols / 2, 0}, {picture.cols / 2, picture.rows},
           cv::Scalar(255, 255, 255));
  if (images.is_vertical) cv::transpose(picture, picture);
  return ColourImage(picture);
}

Image DrawDisparityMap(const RectifiedImages& images, int num_disparities) {
  constexpr int kBlock = 5, kFraction = 16;
  cv::Mat first = RotateToHorizontal(images.first, images.is_vertical);
  cv::Mat second = RotateToHorizontal(images.second, images.is_vertical);
  // Pixels left of num_disparities have no disparity; a border avoids that.
  cv::copyMakeBorder(first, first, 0, 0, num_disparities, 0,
                     cv::BORDER_CONSTANT);
  cv::copyMakeBorder(second, second, 0, 0, num_disparities, 0,
                     cv::BORDER_CONSTANT);
  cv::Mat found;
  cv::StereoSGBM::create(0, num_disparities, kBlock, 8 * kBlock * kBlock,
                         32 * kBlock * kBlock, 1, 0, 10, 100, 2)
      ->compute(first, second, found);
  found = found.colRange(num_disparities, found.cols).clone();
  if (images.is_vertical) cv::transpose(found, found);
  std::vector<double> disparities;
  for (int y = 0; y < found.rows; ++y)
    for (int x = 0; x < found.cols; ++x) {
      const int16_t value = found.at<int16_t>(y, x);
      const bool is_shown =
          images.first_mask.pixels[static_cast<size_t>(y) * found.cols + x];
      disparities.push_back(is_shown && value >= 0
                                ? static_cast<double>(value) / kFraction
                                : NAN);
    }
  return HeatMap(disparities, found.cols, 0, num_disparities, 1);
}

std::string MakeStereoSection(const StereoExample& example) {
  const StereoMetrics& metrics = example.metrics;
  const std::string left = EscapeHtml(metrics.left),
                    right = EscapeHtml(metrics.right);
  const char* const line = metrics.is_vertical ? "column" : "row";
  const char* const place = metrics.is_vertical ? "above" : "on the left";
  const char* const other = metrics.is_vertical ? "below" : "on the right";
  return fmt::format(
             "<h2>Rectified pair: {0} and {1}</h2>\n<p>Corresponding points "
             "are in the same {2} of both images. The residual of common "
             "features is {3:.2g} px RMS, {4:.2g} px max ({5} features). "
             "<code>raygrid rectify rig.yaml --left {0} --right {1} -o "
             "DIR</code> writes blobs and projection matrices.</p>\n",
             left, right, line, metrics.rms_px, metrics.max_px,
             metrics.num_features) +
         fmt::format(
             "<div class=\"pictures\">\n<figure "
             "class=\"wide\"><figcaption>{}: {} {}, {} {}, rectified by the "
             "runtime, with {}s drawn</figcaption>",
             EscapeHtml(metrics.frame), left, place, right, other, line) +
         MakeHtmlImage(example.rows, "Rectified pair") +
         fmt::format(
             "</figure>\n<figure><figcaption>Disparity of {} by OpenCV's "
             "semi-global matching (white: no match). Repetitive patterns "
             "cause wrong matches.</figcaption>",
             left) +
         MakeHtmlImage(example.disparity, "Disparity") +
         MakeHtmlColorBar({ColorScale::kEven, "disparity", "0",
                           fmt::format("{} px", metrics.num_disparities)}) +
         "</figure>\n</div>\n";
}

}  // namespace raygrid
