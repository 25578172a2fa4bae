#include "features/chessboard.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace raygrid {
namespace {

constexpr double kMinSpacingPx = 5;
// Larger images are searched at a size near this first; corners of their
// squares are blurred over several pixels anyway.
constexpr double kSearchPixels = 1.5e6;

double Cross(const cv::Point2f& a, const cv::Point2f& b) {
  return a.x * b.y - a.y * b.x;
}

// Corners in the order of the board, row by row.
class Corners {
 public:
  Corners(std::vector<cv::Point2f> pixels, int columns, int rows)
      : pixels_(std::move(pixels)), columns_(columns), rows_(rows) {}

  const cv::Point2f& at(int column, int row) const {
    return pixels_[row * columns_ + column];
  }

  cv::Point2f AlongColumns() const { return at(columns_ - 1, 0) - at(0, 0); }
  // Columns to rows turn clockwise on the board.
  bool IsMirrored() const {
    return Cross(AlongColumns(), at(0, rows_ - 1) - at(0, 0)) < 0;
  }

  Corners Mirrored() const {
    Corners mirrored = *this;
    for (int row = 0; row < rows_; ++row)
      std::reverse(mirrored.pixels_.begin() + row * columns_,
                   mirrored.pixels_.begin() + (row + 1) * columns_);
    return mirrored;
  }
  Corners TurnedAround() const {
    Corners turned = *this;
    std::reverse(turned.pixels_.begin(), turned.pixels_.end());
    return turned;
  }
  // By a quarter; for boards of as many rows as columns.
  Corners Turned() const {
    Corners turned = *this;
    for (int row = 0; row < rows_; ++row)
      for (int column = 0; column < columns_; ++column)
        turned.pixels_[row * columns_ + column] =
            at(row, columns_ - 1 - column);
    return turned;
  }

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

  // How much brighter squares of odd column + row are than the others, as they
  // are on the board.
  double Contrast(const cv::Mat& image) const {
    double sum[2] = {0, 0};
    int count[2] = {0, 0};
    for (int row = 0; row + 1 < rows_; ++row) {
      for (int column = 0; column + 1 < columns_; ++column) {
        const cv::Point2f center =
            (at(column, row) + at(column + 1, row) + at(column, row + 1) +
             at(column + 1, row + 1)) *
            0.25f;
        sum[(row + column) % 2] += image.at<uint8_t>(cv::Point(center));
        ++count[(row + column) % 2];
      }
    }
    return count[1] == 0 ? 0 : sum[1] / count[1] - sum[0] / count[0];
  }

 private:
  std::vector<cv::Point2f> pixels_;
  int columns_, rows_;
};

using Points = std::vector<cv::Point2f>;

bool FindQuickly(const cv::Mat& image, cv::Size size, Points* found) {
  return cv::findChessboardCorners(image, size, *found,
                                   cv::CALIB_CB_ADAPTIVE_THRESH |
                                       cv::CALIB_CB_NORMALIZE_IMAGE |
                                       cv::CALIB_CB_FAST_CHECK);
}

bool FindThoroughly(const cv::Mat& image, cv::Size size, Points* found) {
  return cv::findChessboardCornersSB(
      image, size, *found,
      cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE);
}

// Within a tenth of a pixel of the shrunk image, lest enlarging makes the error
// more than the refinement can take.
void Sharpen(const cv::Mat& image, Points* found) {
  constexpr int kHalfWindowPx = 4;
  cv::cornerSubPix(
      image, *found, cv::Size(kHalfWindowPx, kHalfWindowPx), cv::Size(-1, -1),
      cv::TermCriteria(cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 50,
                       0.01));
}

// Positions in an image of which each pixel was shrink x shrink.
void Enlarge(int shrink, Points* points) {
  for (cv::Point2f& p : *points) {
    p.x = p.x * shrink + (shrink - 1) / 2.0f;
    p.y = p.y * shrink + (shrink - 1) / 2.0f;
  }
}

int Shrinkage(const cv::Mat& image) {
  return std::max(1, static_cast<int>(std::round(std::sqrt(
                         static_cast<double>(image.total()) / kSearchPixels))));
}

bool FindCorners(const cv::Mat& image, cv::Size size, Points* found) {
  try {
    const int shrink = Shrinkage(image);
    if (shrink == 1)
      return FindQuickly(image, size, found) ||
             FindThoroughly(image, size, found);
    cv::Mat small;
    cv::resize(image(cv::Rect(0, 0, image.cols / shrink * shrink,
                              image.rows / shrink * shrink)),
               small, cv::Size(image.cols / shrink, image.rows / shrink), 0, 0,
               cv::INTER_AREA);
    if (FindQuickly(small, size, found) || FindThoroughly(small, size, found)) {
      Sharpen(small, found);
      Enlarge(shrink, found);
      return true;
    }
    return FindQuickly(image, size, found);
  } catch (const cv::Exception&) {
    return false;  // boards and images too small for OpenCV
  }
}

// All ways to number the corners of an image that is not mirrored.
std::vector<Corners> Numberings(Corners corners, bool is_square) {
  if (corners.IsMirrored()) corners = corners.Mirrored();
  std::vector<Corners> numberings = {corners, corners.TurnedAround()};
  if (is_square) {
    numberings.push_back(corners.Turned());
    numberings.push_back(corners.Turned().TurnedAround());
  }
  return numberings;
}

// The most upright numbering whose colours are right.
std::optional<Corners> Upright(const std::vector<Corners>& numberings,
                               const cv::Mat& image) {
  const auto uprightness = [](const Corners& corners) {
    const cv::Point2f along = corners.AlongColumns();
    return along.x / cv::norm(along);
  };
  std::optional<Corners> best;
  for (const Corners& corners : numberings)
    if (corners.Contrast(image) > 0 &&
        (!best || uprightness(corners) > uprightness(*best)))
      best = corners;
  return best;
}

bool IsOdd(int value) { return value % 2 != 0; }

// Numbers the corners as on the board.
Corners Number(const Corners& found, const Board& board, const cv::Mat& image,
               std::vector<std::string>* remarks) {
  std::vector<Corners> numberings =
      Numberings(found, board.columns == board.rows);
  if (const auto upright = Upright(numberings, image)) return *upright;
  // With both sides odd, mirroring swaps the colours; with both even nothing
  // does but swapped ink.
  const bool is_mirrored = IsOdd(board.columns) && IsOdd(board.rows);
  if (is_mirrored)
    for (Corners& corners : numberings) corners = corners.Mirrored();
  remarks->push_back(fmt::format(
      is_mirrored ? "board {} is mirrored, or its colours are swapped"
                  : "the colours of board {} are swapped",
      board.id));
  return Upright(numberings, is_mirrored ? image : cv::Mat(255 - image))
      .value_or(numberings[0]);
}

}  // namespace

ImageDetection LocateChessboard(const GreyImage& image, const Board& board) {
  const cv::Mat grey(image.size.height, image.size.width, CV_8U,
                     const_cast<uint8_t*>(image.bytes.data()));
  ImageDetection located;
  Points found;
  if (!FindCorners(grey, cv::Size(board.columns, board.rows), &found))
    return located;
  const Corners corners(std::move(found), board.columns, board.rows);
  if (corners.Spacing() < kMinSpacingPx) {
    located.remarks.push_back(
        fmt::format("board {} is too small: its corners are {:.1f} px apart",
                    board.id, corners.Spacing()));
    return located;
  }
  const Corners numbered = Number(corners, board, grey, &located.remarks);
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      const cv::Point2f& p = numbered.at(column, row);
      located.features.push_back({board.id, column, row, {p.x, p.y}});
    }
  }
  return located;
}

}  // namespace raygrid
