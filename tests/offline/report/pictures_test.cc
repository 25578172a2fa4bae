#include "report/pictures.h"

#include <set>

#include "report/uncertainty_picture.h"
#include "support.h"

namespace raygrid {
namespace {

TEST(Pictures, HaveTheImagesSize) {
  const std::vector<FeatureResidual> residuals = {
      {"a", 0, 0, 0, {100, 200}, {1, 0}}, {"a", 0, 0, 0, {500, 200}, {0, 3}}};
  const ImageSize size = {640, 480};
  const Area area = {10, 10, 600, 400};
  for (const Image& picture : {CoveragePicture(residuals, size, area),
                               DirectionPicture(residuals, size, area),
                               MagnitudePicture(residuals, size, area, 0.3),
                               DirectionPicture({}, size, area)}) {
    EXPECT_EQ(picture.size, size);
    EXPECT_EQ(picture.pixels.size(), 640u * 480u * picture.channels);
  }
}

std::vector<uint8_t> PixelOf(const Image& image, int x, int y) {
  const auto at = image.pixels.begin() + 3 * (image.size.width * y + x);
  return {at, at + 3};
}

TEST(Pictures, DirectionIsThatOfTheNearestResidual) {
  const std::vector<FeatureResidual> residuals = {
      {"a", 0, 0, 0, {100, 200}, {1, 0}}, {"a", 0, 0, 0, {500, 200}, {0, 3}}};
  const Image picture =
      DirectionPicture(residuals, {640, 480}, {0, 0, 639, 479});
  const Image legend = DirectionLegend(101);
  EXPECT_EQ(PixelOf(picture, 50, 400), PixelOf(legend, 95, 50));
  EXPECT_EQ(PixelOf(picture, 600, 10), PixelOf(legend, 50, 95));
  EXPECT_NE(PixelOf(picture, 50, 400), PixelOf(picture, 600, 10));
}

TEST(Pictures, FeaturesOnTheImagesEdgeAreDrawnToo) {
  const std::vector<FeatureResidual> residuals = {
      {"a", 0, 0, 0, {-0.5, -0.5}, {1, 0}},
      {"a", 0, 0, 0, {639.49, 479.49}, {0, 0}}};
  const Image picture =
      MagnitudePicture(residuals, {640, 480}, {-0.5, -0.5, 639.5, 479.5}, 1);
  EXPECT_NE(PixelOf(picture, 0, 0), PixelOf(picture, 639, 479));
}

TEST(UncertaintyPicture, IsHatchedWhereNotTrustedAndGreyOutside) {
  CameraUncertainty uncertainty;
  uncertainty.lattice = {2, 2, {0.001, 0.001, 0.001, 0.001}};
  uncertainty.max_deviation_px = 0.01;
  uncertainty.mask = TrustMask::Over({800, 600});
  for (int cell = 0; cell < uncertainty.mask.columns * uncertainty.mask.rows;
       ++cell)
    uncertainty.mask.is_trusted[cell] =
        uncertainty.mask.CellCenter(cell).x() < 400;
  const Image image =
      UncertaintyPicture(uncertainty, {800, 600}, {100, 100, 700, 500});
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

}  // namespace
}  // namespace raygrid
