#include <cmath>
#include <set>

#include "report/color_scale.h"
#include "report/plots.h"
#include "report/stereo_figures.h"
#include "report/uncertainty_plot.h"
#include "support.h"

namespace raygrid {
namespace {

TEST(Pictures, HaveTheImagesSize) {
  const std::vector<FeatureResidual> residuals = {
      {"a", 0, 0, 0, {100, 200}, {1, 0}}, {"a", 0, 0, 0, {500, 200}, {0, 3}}};
  const ImageSize size = {640, 480};
  const Area area = {10, 10, 600, 400};
  for (const Image& picture : {DrawCoveragePlot(residuals, size, area),
                               DrawDirectionPlot(residuals, size, area),
                               DrawMagnitudePlot(residuals, size, area, 0.3),
                               DrawDirectionPlot({}, size, area)}) {
    EXPECT_EQ(picture.size, size);
    EXPECT_EQ(picture.pixels.size(), 640u * 480u * picture.channels);
  }
}

std::vector<uint8_t> GetPixel(const Image& image, int x, int y) {
  const auto at = image.pixels.begin() + 3 * (image.size.width * y + x);
  return {at, at + 3};
}

TEST(Pictures, DirectionIsThatOfTheNearestResidual) {
  const std::vector<FeatureResidual> residuals = {
      {"a", 0, 0, 0, {100, 200}, {1, 0}}, {"a", 0, 0, 0, {500, 200}, {0, 3}}};
  const Image picture =
      DrawDirectionPlot(residuals, {640, 480}, {0, 0, 639, 479});
  const Image legend = DrawDirectionLegend(101);
  EXPECT_EQ(GetPixel(picture, 50, 400), GetPixel(legend, 95, 50));
  EXPECT_EQ(GetPixel(picture, 600, 10), GetPixel(legend, 50, 95));
  EXPECT_NE(GetPixel(picture, 50, 400), GetPixel(picture, 600, 10));
}

TEST(Pictures, FeaturesOnTheImagesEdgeAreDrawnToo) {
  const std::vector<FeatureResidual> residuals = {
      {"a", 0, 0, 0, {-0.5, -0.5}, {1, 0}},
      {"a", 0, 0, 0, {639.49, 479.49}, {0, 0}}};
  const Image picture =
      DrawMagnitudePlot(residuals, {640, 480}, {-0.5, -0.5, 639.5, 479.5}, 1);
  EXPECT_NE(GetPixel(picture, 0, 0), GetPixel(picture, 639, 479));
}

TEST(DrawDisplacementPlot, IsTheSizeInColoursUnderArrowsAndWhiteWithout) {
  constexpr int kColumns = 12, kCellPx = 8;
  std::vector<Eigen::Vector2d> displacements(kColumns * 12, {0.5, 0});
  displacements[0] = {NAN, NAN};
  const Image picture = DrawDisplacementPlot(displacements, kColumns, 1);
  EXPECT_EQ(picture.size, (ImageSize{kColumns * kCellPx, 12 * kCellPx}));
  EXPECT_EQ(GetPixel(picture, 2, 2), (std::vector<uint8_t>{255, 255, 255}));
  const auto half = GetColor(ColorScale::kEven, 0.5);
  EXPECT_EQ(GetPixel(picture, kCellPx + 2, 2),
            std::vector<uint8_t>(half.begin(), half.end()));
  // The first arrow lies across the middle of cell 3, 3, half as long as arrows
  // are apart, and its head is on the right.
  constexpr int kMiddle = kCellPx * 3 + kCellPx / 2;
  const auto level = [&](int dx, int dy) {
    return GetPixel(picture, kMiddle + dx, kMiddle + dy)[0];
  };
  EXPECT_GT(level(-8, 0), 200);
  EXPECT_GT(level(8, 0), 200);
  EXPECT_GT(level(8, 4), 200);
  EXPECT_LT(level(-8, 4), 200);
  EXPECT_LT(level(-18, 0), 200);
  EXPECT_LT(level(18, 0), 200);
}

TEST(DrawUncertaintyPlot, IsHatchedWhereNotTrustedAndGreyOutside) {
  CameraUncertainty uncertainty;
  uncertainty.lattice = {2, 2, {0.001, 0.001, 0.001, 0.001}};
  uncertainty.max_stddev_px = 0.01;
  uncertainty.mask = ValidityMask::Over({800, 600});
  for (int cell = 0; cell < uncertainty.mask.columns * uncertainty.mask.rows;
       ++cell)
    uncertainty.mask.is_valid[cell] =
        uncertainty.mask.CellCenter(cell).x() < 400;
  const Image image =
      DrawUncertaintyPlot(uncertainty, {800, 600}, {100, 100, 700, 500});
  EXPECT_EQ(image.size.width, 800);
  const auto count_colors = [&image](int first_x, int last_x) {
    std::set<std::vector<uint8_t>> colors;
    for (int x = first_x; x < last_x; ++x) {
      const uint8_t* pixel = image.pixels.data() + 300 * image.stride() + 3 * x;
      colors.insert({pixel, pixel + 3});
    }
    return colors;
  };
  EXPECT_EQ(count_colors(10, 90),
            (std::set<std::vector<uint8_t>>{{128, 128, 128}}));
  EXPECT_EQ(count_colors(120, 380).size(), 1u);
  EXPECT_EQ(count_colors(420, 680).size(), 2u);
}

// A random texture, of which the second image is 20 px farther along the rows.
RectifiedImages ShiftedTexture() {
  constexpr int kShiftPx = 20;
  TestRandom random(3);
  const ImageSize size = {200, 100};
  RectifiedImages images;
  for (Image* image : {&images.first, &images.second, &images.first_mask}) {
    image->size = size;
    image->pixels.assign(static_cast<size_t>(size.width) * size.height, 255);
  }
  for (uint8_t& level : images.first.pixels)
    level = static_cast<uint8_t>(random.Index(256));
  for (size_t k = 0; k + kShiftPx < images.first.pixels.size(); ++k)
    images.second.pixels[k] = images.first.pixels[k + kShiftPx];
  return images;
}

TEST(StereoPictures, DisparitiesAreThoseOfTheImages) {
  RectifiedImages images = ShiftedTexture();
  for (size_t k = 0; k < 50 * 200; ++k) images.first_mask.pixels[k] = 0;
  const Image picture = DrawDisparityMap(images, 64);
  EXPECT_EQ(picture.size, images.first.size);
  const auto expected = GetColor(ColorScale::kEven, 20.0 / 64);
  int num_right = 0, num_white = 0;
  for (int y = 0; y < 100; ++y)
    for (int x = 64; x < 200; ++x) {
      const std::vector<uint8_t> pixel = GetPixel(picture, x, y);
      num_white += y < 50 && pixel == std::vector<uint8_t>{255, 255, 255};
      num_right +=
          y >= 50 && std::equal(pixel.begin(), pixel.end(), expected.begin());
    }
  EXPECT_EQ(num_white, 50 * 136);
  EXPECT_GT(num_right, 0.9 * 50 * 136);
}

TEST(StereoPictures, VerticalPairsAreThoseThatLieDown) {
  const RectifiedImages images = ShiftedTexture();
  const auto transposed = [](const Image& image) {
    Image turned = image;
    turned.size = {image.size.height, image.size.width};
    const size_t n = image.channels;
    for (int y = 0; y < image.size.height; ++y)
      for (int x = 0; x < image.size.width; ++x)
        for (size_t c = 0; c < n; ++c)
          turned.pixels[n * (x * image.size.height + y) + c] =
              image.pixels[n * (y * image.size.width + x) + c];
    return turned;
  };
  const RectifiedImages standing = {transposed(images.first),
                                    transposed(images.second),
                                    transposed(images.first_mask), true};
  EXPECT_EQ(DrawDisparityMap(standing, 64).pixels,
            transposed(DrawDisparityMap(images, 64)).pixels);
  const Image rows = DrawRectifiedRows(images);
  EXPECT_EQ(rows.size, (ImageSize{400, 100}));
  EXPECT_EQ(DrawRectifiedRows(standing).pixels, transposed(rows).pixels);
}

}  // namespace
}  // namespace raygrid
