// Ink and features of the PDF, in place on the page.
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "appearance/board_appearance.h"
#include "boards_to_print.h"
#include "dataset/files.h"
#include "features/pattern_detector.h"
#include "support.h"
#include "target/board_sheet.h"

namespace raygrid {
namespace {

cv::Mat Rasterised(const std::string& pdf, int dpi) {
  const TemporaryFolder folder;
  WriteFile(folder / "a.pdf", pdf);
  const std::string command = "pdftoppm -gray -singlefile -r " +
                              std::to_string(dpi) + " '" + (folder / "a.pdf") +
                              "' '" + (folder / "a") + "' 2>/dev/null";
  if (std::system(command.c_str()) != 0) return {};
  return cv::imread(folder / "a.pgm", cv::IMREAD_GRAYSCALE);
}

// The ink rectangle as it ought to be, one sample for each pixel.
struct ExpectedInk {
  ExpectedInk(const BoardSheets& sheets, int dpi)
      : appearance(sheets.boards[0]), pixel_m(0.0254 / dpi) {
    const Area& mm = sheets.board_mm;
    const double px = dpi / 25.4;
    rect = cv::Rect(
        cv::Point(std::floor(mm.x0 * px) - 3, std::floor(mm.y0 * px) - 3),
        cv::Point(std::ceil(mm.x1 * px) + 3, std::ceil(mm.y1 * px) + 3));
    origin_m =
        Eigen::Vector2d(mm.x0, mm.y0) / 1000 -
        Eigen::Vector2d(appearance.extent_m().x0, appearance.extent_m().y0);
    image.create(rect.size(), CV_8U);
    for (int y = 0; y < rect.height; ++y)
      for (int x = 0; x < rect.width; ++x)
        image.at<uint8_t>(y, x) = IsBlackAt(x, y) ? 0 : 255;
  }
  bool IsBlackAt(double x, double y) const {
    const Eigen::Vector2d pixel(rect.x + x + 0.5, rect.y + y + 0.5);
    return appearance.IsBlack(pixel * pixel_m - origin_m);
  }
  // Whether the colour changes within a pixel's distance.
  bool IsNearEdge(int x, int y) const {
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        if (IsBlackAt(x + dx, y + dy) != IsBlackAt(x, y)) return true;
    return false;
  }

  BoardAppearance appearance;
  double pixel_m;
  Eigen::Vector2d origin_m;
  cv::Rect rect;
  cv::Mat image;
};

// How far one picture of a region is shifted from another, by least squares.
Eigen::Vector2d ShiftPx(const cv::Mat& seen, const cv::Mat& expected) {
  cv::Mat a, b, gx, gy;
  seen.convertTo(a, CV_32F);
  expected.convertTo(b, CV_32F);
  cv::GaussianBlur(a, a, {9, 9}, 1.5);
  cv::GaussianBlur(b, b, {9, 9}, 1.5);
  cv::Sobel(b, gx, CV_32F, 1, 0, 3, 1 / 8.);
  cv::Sobel(b, gy, CV_32F, 0, 1, 3, 1 / 8.);
  const cv::Mat d = b - a;
  Eigen::Matrix2d h;
  h << gx.dot(gx), gx.dot(gy), gx.dot(gy), gy.dot(gy);
  return h.inverse() * Eigen::Vector2d(gx.dot(d), gy.dot(d));
}

void ExpectInkInPlace(const Board& board) {
  constexpr int kDpi = 600;
  // 2400 pixels: no rounding of the page's size.
  const BoardSheets sheets = PlanBoardSheets({board}, {101.6, 101.6});
  const cv::Mat page = Rasterised(SheetsPdf(sheets), kDpi);
  if (page.empty())
    GTEST_SKIP() << "no pdftoppm, which rasterises the page; "
                    "install poppler-utils";
  ASSERT_EQ(page.size(), cv::Size(2400, 2400));
  const ExpectedInk expected(sheets, kDpi);
  const cv::Mat seen = page(expected.rect);
  int num_wrong = 0;
  for (int y = 0; y < seen.rows; ++y)
    for (int x = 0; x < seen.cols; ++x)
      if ((seen.at<uint8_t>(y, x) < 128) !=
          (expected.image.at<uint8_t>(y, x) < 128))
        num_wrong += !expected.IsNearEdge(x, y);
  EXPECT_EQ(num_wrong, 0);
  double worst_mm = 0;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) {
      const cv::Rect region(column * seen.cols / 3, row * seen.rows / 3,
                            seen.cols / 3, seen.rows / 3);
      const Eigen::Vector2d shift_px =
          ShiftPx(seen(region), expected.image(region));
      worst_mm =
          std::max(worst_mm, shift_px.cwiseAbs().maxCoeff() * 25.4 / kDpi);
    }
  EXPECT_LT(worst_mm, 0.02);
  ::testing::Test::RecordProperty("worst_shift_um",
                                  std::to_string(1000 * worst_mm));
}

TEST(PrintedInk, OfStarsIsInPlace) {
  ExpectInkInPlace(StarBoards(Stars(9, 9, 7.77))[0]);
}
TEST(PrintedInk, OfSixSegmentsIsInPlace) {
  StarBoardOptions options = Stars(6, 6, 11);
  options.segments = 6;
  ExpectInkInPlace(StarBoards(options)[0]);
}
TEST(PrintedInk, OfCharucoIsInPlace) { ExpectInkInPlace(Charuco(6, 5, 11.3)); }
TEST(PrintedInk, OfAprilGridsIsInPlace) {
  ExpectInkInPlace(AprilGrid(3, 3, 19.3));
}

// On the page, as pattern.yaml says.
Eigen::Vector2d FirstFeatureMm(const std::string& yaml) {
  const std::string key = "first_feature_m: [";
  Eigen::Vector2d place(NAN, NAN);
  std::sscanf(yaml.c_str() + yaml.find(key) + key.size(), "%lf, %lf",
              &place.x(), &place.y());
  return 1000 * place;
}

// Nothing is fitted: pixels are lengths on the page.
void ExpectFeaturesInPlace(const Board& drawn) {
  constexpr int kDpi = 600;
  const BoardSheets sheets = PlanBoardSheets({drawn}, {101.6, 101.6});
  const std::string yaml = MakeSheetsYaml(sheets);
  const Pattern pattern = ParsePattern("sheet", yaml);
  const Board& board = pattern.boards[0];
  const cv::Mat page = Rasterised(SheetsPdf(sheets), kDpi);
  if (page.empty())
    GTEST_SKIP() << "no pdftoppm, which rasterises the page; "
                    "install poppler-utils";
  Image image;
  image.size = {page.cols, page.rows};
  image.pixels.assign(page.datastart, page.dataend);
  const ImageDetection seen =
      PatternDetector(pattern, {}).Detect(MakeGreyImage(image));
  size_t num_features = 0;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      num_features += board.HasFeature(column, row);
  EXPECT_EQ(seen.features.size(), num_features);
  for (const RejectedFeature& rejected : seen.rejected)
    ADD_FAILURE() << rejected.feature.column << ", " << rejected.feature.row
                  << ": " << rejected.reason;
  const Eigen::Vector2d first_mm = FirstFeatureMm(yaml);
  double worst_mm = 0;
  for (const Feature& feature : seen.features) {
    const Eigen::Vector2d seen_mm =
        (feature.pixel + Eigen::Vector2d(0.5, 0.5)) * 25.4 / kDpi;
    const Eigen::Vector3d& point =
        board.points[board.PointIndex(feature.column, feature.row)];
    worst_mm = std::max(worst_mm,
                        (seen_mm - first_mm - 1000 * point.head<2>()).norm());
  }
  EXPECT_LT(worst_mm, 0.02);
  std::printf("%s: %zu features, at most %.4f mm off\n", board.kind.c_str(),
              seen.features.size(), worst_mm);
  ::testing::Test::RecordProperty("worst_um", std::to_string(1000 * worst_mm));
}

TEST(PrintedFeatures, OfStarsAreDetectedInPlace) {
  ExpectFeaturesInPlace(StarBoards(Stars(10, 9, 7.3))[0]);
}

TEST(PrintedFeatures, OfChessboardsAreDetectedInPlace) {
  ExpectFeaturesInPlace(Chessboard(8, 5, 8.3));
}

TEST(PrintedFeatures, OfCharucoAreDetectedInPlace) {
  ExpectFeaturesInPlace(Charuco(7, 4, 9.1));
}

TEST(PrintedFeatures, OfAprilGridsAreDetectedInPlace) {
  ExpectFeaturesInPlace(AprilGrid(4, 4, 14.7));
}

}  // namespace
}  // namespace raygrid
