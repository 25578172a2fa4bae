#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "features/feature_detection.h"

namespace raygrid {
namespace {

cv::Mat View(const Image& grey) {
  return cv::Mat(grey.size.height, grey.size.width, CV_8UC1,
                 const_cast<uint8_t*>(grey.pixels.data()));
}

// Corners in the order of the board, row by row.
class Corners {
 public:
  Corners(std::vector<cv::Point2f> pixels, int columns, int rows)
      : pixels_(std::move(pixels)), columns_(columns), rows_(rows) {}

  const cv::Point2f& at(int column, int row) const {
    return pixels_[row * columns_ + column];
  }
  std::vector<cv::Point2f>& pixels() { return pixels_; }

  // Columns to rows must turn clockwise in the image, as on the board.
  bool IsMirrored() const {
    const cv::Point2f u = at(columns_ - 1, 0) - at(0, 0);
    const cv::Point2f v = at(0, rows_ - 1) - at(0, 0);
    return u.x * v.y - u.y * v.x < 0;
  }
  void MirrorColumns() {
    for (int row = 0; row < rows_; ++row)
      std::reverse(pixels_.begin() + row * columns_,
                   pixels_.begin() + (row + 1) * columns_);
  }
  void TurnAround() { std::reverse(pixels_.begin(), pixels_.end()); }

  // The smallest distance between neighbours.
  double Spacing() const {
    double spacing = INFINITY;
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        if (column > 0)
          spacing = std::min(spacing,
                             cv::norm(at(column, row) - at(column - 1, row)));
        if (row > 0)
          spacing = std::min(spacing,
                             cv::norm(at(column, row) - at(column, row - 1)));
      }
    }
    return spacing;
  }

  // Mean brightness of the squares of even or odd column + row.
  double Brightness(const cv::Mat& image, int parity) const {
    double sum = 0;
    int count = 0;
    for (int row = 0; row + 1 < rows_; ++row) {
      for (int column = 0; column + 1 < columns_; ++column) {
        if ((row + column) % 2 != parity) continue;
        const cv::Point2f center =
            (at(column, row) + at(column + 1, row) + at(column, row + 1) +
             at(column + 1, row + 1)) *
            0.25f;
        sum += image.at<uint8_t>(cv::Point(center));
        ++count;
      }
    }
    return sum / std::max(count, 1);
  }

 private:
  std::vector<cv::Point2f> pixels_;
  int columns_, rows_;
};

constexpr double kMinSpacingPx = 5;

// Half the window of the sub-pixel refinement: it should stay between the
// neighbouring corners, whatever the perspective.
int HalfWindow(double spacing_px) {
  return std::clamp(static_cast<int>(0.4 * spacing_px), 2, 11);
}

}  // namespace

std::vector<Feature> DetectChessboard(const Image& grey, const Board& board) {
  const cv::Mat image = View(grey);
  std::vector<cv::Point2f> found;
  if (!cv::findChessboardCorners(
          image, cv::Size(board.columns, board.rows), found,
          cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE |
              cv::CALIB_CB_FAST_CHECK))
    return {};
  Corners corners(std::move(found), board.columns, board.rows);
  const double spacing = corners.Spacing();
  if (spacing < kMinSpacingPx) return {};
  const int half = HalfWindow(spacing);
  cv::cornerSubPix(
      image, corners.pixels(), cv::Size(half, half), cv::Size(-1, -1),
      cv::TermCriteria(cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 100,
                       1e-4));

  if (corners.IsMirrored()) corners.MirrorColumns();
  // The square right below the first corner is dark.
  if (corners.Brightness(image, 0) > corners.Brightness(image, 1))
    corners.TurnAround();

  std::vector<Feature> features;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      const cv::Point2f& p = corners.at(column, row);
      features.push_back({board.id, column, row, {p.x, p.y}});
    }
  }
  return features;
}

Image DrawFeatures(const Image& grey, const std::vector<Feature>& features) {
  cv::Mat color;
  cv::cvtColor(View(grey), color, cv::COLOR_GRAY2BGR);
  constexpr int kShift = 4;
  for (const Feature& feature : features) {
    const cv::Point center(
        static_cast<int>(std::lround(feature.pixel.x() * 16)),
        static_cast<int>(std::lround(feature.pixel.y() * 16)));
    const bool is_first = feature.column == 0 && feature.row == 0;
    cv::circle(color, center, (is_first ? 6 : 3) << kShift,
               is_first ? cv::Scalar(0, 0, 255) : cv::Scalar(0, 200, 0), 1,
               cv::LINE_AA, kShift);
  }
  Image drawn;
  drawn.size = grey.size;
  drawn.channels = 3;
  drawn.pixels.assign(color.datastart, color.dataend);
  return drawn;
}

}  // namespace raygrid
