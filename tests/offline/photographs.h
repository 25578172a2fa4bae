// Photographs of boards, drawn with the truth beside them.
#ifndef RAYGRID_TESTS_OFFLINE_PHOTOGRAPHS_H
#define RAYGRID_TESTS_OFFLINE_PHOTOGRAPHS_H

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "appearance/board_appearance.h"
#include "features/pattern_detector.h"
#include "support.h"

namespace raygrid {

inline constexpr int kScale = 4;     // supersampling
inline constexpr int kSquare = 100;  // on the drawn board
inline const cv::Size kSize(640, 480);

// A board drawn pixel by pixel, with a white margin of one square.
class Drawing {
 public:
  explicit Drawing(const Board& board) : board_(board), appearance_(board) {
    const Area& extent = appearance_.extent_m();
    origin_m_ = Eigen::Vector2d(extent.x0, extent.y0).array() - board.square_m;
    const int margins = 2 * kSquare;
    image_ = cv::Mat(
        margins + static_cast<int>(std::lround(extent.height() * PerMetre())),
        margins + static_cast<int>(std::lround(extent.width() * PerMetre())),
        CV_8U);
    for (int y = 0; y < image_.rows; ++y)
      for (int x = 0; x < image_.cols; ++x)
        image_.at<uint8_t>(y, x) =
            appearance_.IsBlack(PointAt(x, y)) ? 25 : 230;
  }

  const cv::Mat& image() const { return image_; }
  cv::Vec3d Place(int column, int row) const {
    const Eigen::Vector2d point =
        board_.points[board_.PointIndex(column, row)].head<2>();
    const Eigen::Vector2d place =
        ((point - origin_m_) * PerMetre()).array() - 0.5;
    return {place.x(), place.y(), 1};
  }

 private:
  double PerMetre() const { return kSquare / board_.square_m; }
  Eigen::Vector2d PointAt(int x, int y) const {
    return origin_m_ + Eigen::Vector2d(x + 0.5, y + 0.5) / PerMetre();
  }

  Board board_;
  BoardAppearance appearance_;
  Eigen::Vector2d origin_m_;
  cv::Mat image_;
};

inline Image ToGrey(const cv::Mat& mat) {
  Image image;
  image.size = {mat.cols, mat.rows};
  image.pixels.assign(mat.datastart, mat.dataend);
  return image;
}

// A photograph of a board, with a lens's blur; the drawing's corners are at a
// quadrangle of the image.
class Photograph {
 public:
  Photograph(const Board& board, const std::vector<cv::Point2f>& quad)
      : drawing_(board) {
    const float w = drawing_.image().cols - 0.5f;
    const float h = drawing_.image().rows - 0.5f;
    to_image_ = cv::Matx33d(cv::getPerspectiveTransform(
        std::vector<cv::Point2f>{
            {-0.5f, -0.5f}, {w, -0.5f}, {w, h}, {-0.5f, h}},
        quad));
    const double offset = (kScale - 1) / 2.0;
    const cv::Matx33d enlarge(kScale, 0, offset, 0, kScale, offset, 0, 0, 1);
    cv::Mat large;
    cv::warpPerspective(drawing_.image(), large, enlarge * to_image_,
                        kSize * kScale, cv::INTER_LINEAR, cv::BORDER_CONSTANT,
                        cv::Scalar(140));
    cv::resize(large, mat, kSize, 0, 0, cv::INTER_AREA);
    cv::GaussianBlur(mat, mat, cv::Size(), 0.7);
  }

  Image image() const { return ToGrey(mat); }
  Eigen::Vector2d Truth(const Feature& f) const {
    const cv::Vec3d p = to_image_ * drawing_.Place(f.column, f.row);
    return {p[0] / p[2], p[1] / p[2]};
  }
  // A place in squares from the first feature.
  cv::Point2d ToImage(double column, double row) const {
    const cv::Vec3d origin = drawing_.Place(0, 0);
    const cv::Vec3d p = to_image_ * cv::Vec3d(origin[0] + column * kSquare,
                                              origin[1] + row * kSquare, 1);
    return {p[0] / p[2], p[1] / p[2]};
  }
  // How many features lie in the image, that far from its edge at least.
  int NumVisible(const Board& board, double margin_px) const {
    int count = 0;
    for (int row = 0; row < board.rows; ++row)
      for (int column = 0; column < board.columns; ++column)
        count += WholeImage({mat.cols, mat.rows})
                     .Contains(Truth({board.id, column, row, {}}), -margin_px);
    return count;
  }
  double WorstErrorPx(const std::vector<Feature>& features) const {
    double worst = 0;
    for (const Feature& f : features)
      worst = std::max(worst, (f.pixel - Truth(f)).norm());
    return worst;
  }

  cv::Mat mat;

 private:
  Drawing drawing_;
  cv::Matx33d to_image_;
};

inline const std::vector<cv::Point2f> kFrontal = {
    {100, 80}, {540, 100}, {530, 400}, {110, 390}};
inline const std::vector<cv::Point2f> kTilted = {
    {60, 120}, {560, 30}, {600, 440}, {140, 380}};
inline const std::vector<cv::Point2f> kUpsideDown = {
    {530, 400}, {110, 390}, {100, 80}, {540, 100}};
inline const std::vector<cv::Point2f> kOnItsSide = {
    {500, 20}, {510, 460}, {60, 450}, {80, 30}};
inline const std::vector<cv::Point2f> kHalfOutside = {
    {-300, 40}, {560, 60}, {550, 440}, {-280, 450}};

inline const std::vector<cv::Point2f> kAllAround = {
    {-300, -240}, {960, -200}, {930, 690}, {-280, 700}};
inline const std::vector<cv::Point2f> kSmall = {
    {200, 150}, {420, 155}, {415, 318}, {205, 310}};

inline Pattern CharucoPattern(int columns, int rows, bool is_legacy = false) {
  return ParsePattern(
      "charuco",
      "raygrid_pattern: 1\nboards:\n  - {id: 3, kind: charuco, columns: " +
          std::to_string(columns) + ", rows: " + std::to_string(rows) +
          ", square_m: 0.02, marker_m: 0.015, dictionary: DICT_4X4_1000, "
          "legacy: " +
          (is_legacy ? "true" : "false") + "}\n");
}

inline Pattern AprilGridPattern() {
  return ParsePattern("aprilgrid",
                      "raygrid_pattern: 1\nboards:\n  - {id: 1, kind: "
                      "aprilgrid, columns: 10, rows: 8, square_m: 0.03, "
                      "spacing_ratio: 0.3}\n");
}

inline ImageDetection Detected(const Image& image, const Pattern& pattern,
                               const DetectionOptions& options = {}) {
  return PatternDetector(pattern, options).Detect(MakeGreyImage(image));
}

// Those of an image that went through a file.
inline std::vector<Feature> FeaturesInFile(const cv::Mat& image,
                                           const Pattern& pattern) {
  const TemporaryFolder folder;
  EXPECT_TRUE(cv::imwrite(folder / "a.png", image));
  return DetectFeatures({folder / "a.png"}, pattern, 1, nullptr)
      .images[0]
      .features;
}

inline bool IsInBoardOrder(const std::vector<Feature>& features) {
  return std::is_sorted(
      features.begin(), features.end(), [](const Feature& a, const Feature& b) {
        return std::tie(a.row, a.column) < std::tie(b.row, b.column);
      });
}

inline Image TurnedAround(Image image) {
  std::reverse(image.pixels.begin(), image.pixels.end());
  return image;
}

inline Image MirrorImage(const Photograph& photograph) {
  cv::Mat mirrored;
  cv::flip(photograph.mat, mirrored, 1);
  return ToGrey(mirrored);
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_PHOTOGRAPHS_H
