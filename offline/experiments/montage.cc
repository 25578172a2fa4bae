#include "experiments/montage.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "report/color_scale.h"

namespace raygrid {
namespace {

constexpr int kMontageColumns = 3, kWidth = 400, kMargin = 12, kCaption = 26;
constexpr int kLineHeight = 22;

cv::Mat Matrix(const Image& image) {
  return cv::Mat(image.size.height, image.size.width, CV_8UC3,
                 const_cast<uint8_t*>(image.pixels.data()));
}

void DrawText(const std::string& text, int x, int y, cv::Mat* montage) {
  cv::putText(*montage, text, {x, y}, cv::FONT_HERSHEY_SIMPLEX, 0.5,
              cv::Scalar(0, 0, 0), 1, cv::LINE_AA);
}

Image ToImage(const cv::Mat& picture) {
  Image image;
  image.size = {picture.cols, picture.rows};
  image.channels = 3;
  image.pixels.assign(picture.datastart, picture.dataend);
  return image;
}

}  // namespace

Image ComposeMontage(const std::vector<MontageImage>& pictures,
                     const std::vector<std::string>& note,
                     const Image* legend) {
  const int count = static_cast<int>(pictures.size());
  const int columns = std::min(kMontageColumns, count);
  const int rows = (count + columns - 1) / columns;
  const ImageSize& first = pictures[0].image.size;
  const int height = kWidth * first.height / first.width;
  const int cell = kCaption + height + kMargin;
  const int footer = std::max(static_cast<int>(note.size()) * kLineHeight,
                              legend ? legend->size.height : 0) +
                     2 * kMargin;
  cv::Mat montage(rows * cell + footer,
                  std::max(2, columns) * (kWidth + kMargin) + kMargin, CV_8UC3,
                  cv::Scalar(255, 255, 255));
  for (int i = 0; i < count; ++i) {
    const int x = kMargin + i % columns * (kWidth + kMargin);
    const int y = i / columns * cell;
    DrawText(pictures[i].caption, x, y + kCaption - 7, &montage);
    cv::resize(Matrix(pictures[i].image),
               montage(cv::Rect(x, y + kCaption, kWidth, height)),
               {kWidth, height}, 0, 0, cv::INTER_NEAREST);
  }
  int x = kMargin;
  const int y = rows * cell + kMargin;
  if (legend) {
    Matrix(*legend).copyTo(
        montage(cv::Rect(x, y, legend->size.width, legend->size.height)));
    x += legend->size.width + kMargin;
  }
  for (size_t i = 0; i < note.size(); ++i)
    DrawText(note[i], x, y + 15 + static_cast<int>(i) * kLineHeight, &montage);
  return ToImage(montage);
}

Image DrawColorLegend(ColorScale scale, const std::string& low,
                      const std::string& high) {
  constexpr int kBarWidth = 240, kBarHeight = 18;
  cv::Mat legend(kBarHeight + 24, kBarWidth + 60, CV_8UC3,
                 cv::Scalar(255, 255, 255));
  for (int x = 0; x < kBarWidth; ++x) {
    const auto color = GetColor(scale, double(x) / (kBarWidth - 1));
    legend.col(x)
        .rowRange(0, kBarHeight)
        .setTo(cv::Scalar(color[0], color[1], color[2]));
  }
  DrawText(low, 0, kBarHeight + 18, &legend);
  DrawText(high, kBarWidth - 40, kBarHeight + 18, &legend);
  return ToImage(legend);
}

}  // namespace raygrid
