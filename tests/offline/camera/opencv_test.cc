#include "camera/opencv.h"

#include "support.h"

namespace raygrid {
namespace {

// Barrel distortion that folds at r = 1 / sqrt(-3 k1).
OpenCvModel FoldingLens(double k1) {
  const ImageSize size = {640, 480};
  return OpenCvModel(size, WholeImage(size),
                     {300, 300, 320, 240, k1, 0, 0, 0, 0, 0, 0, 0});
}

TEST(OpenCvModel, ProjectsNothingFromBehind) {
  const OpenCvModel lens = ExampleLens();
  EXPECT_TRUE(lens.Project({0, 0, 1}));
  EXPECT_FALSE(lens.Project({0, 0, -1}));
  EXPECT_FALSE(lens.Project({0.1, 0.1, -1}));
  EXPECT_FALSE(lens.Project({0.1, 0.1, 0}));
  EXPECT_FALSE(lens.Project({0, 0, 0}));
  EXPECT_FALSE(lens.Project({NAN, 0, 1}));
}

TEST(OpenCvModel, ProjectsNothingBeyondItsFold) {
  const OpenCvModel lens = FoldingLens(-0.5);
  const double fold = 1 / std::sqrt(1.5);
  EXPECT_TRUE(lens.Project({fold - 0.02, 0, 1}));
  // These would land within the image, where others are seen.
  EXPECT_FALSE(lens.Project({fold + 0.02, 0, 1}));
  EXPECT_FALSE(lens.Project({0, -1.2, 1}));
  EXPECT_FALSE(lens.Project({1.4, 0, 1}));
}

TEST(OpenCvModel, UnprojectsNothingThatNoDirectionReaches) {
  const OpenCvModel lens = FoldingLens(-0.5);
  // The fold is 300 * 2/3 * 0.816 = 163 px from the centre.
  EXPECT_TRUE(lens.Unproject({320 + 155, 240}));
  EXPECT_FALSE(lens.Unproject({320 + 170, 240}));
  EXPECT_FALSE(lens.Unproject({0, 0}));
}

// Numerator and denominator nearly cancel, but for a bump of the distortion
// that is a few pixels wide. Newton's method went astray at 263 of these
// pixels.
TEST(OpenCvModel, UnprojectsBesideANarrowBump) {
  const ImageSize size = {1280, 960};
  const OpenCvModel lens(size, WholeImage(size),
                         {1800, 1800, 639.5, 479.5, -33.203632, 276.496937, 0,
                          -33.233632, 276.946937, 0, 0.002, -0.001});
  int num_without = 0;
  for (int y = 0; y < 960; y += 8)
    for (int x = 0; x < 1280; x += 8) {
      const Eigen::Vector2d pixel(x, y);
      const auto ray = lens.Unproject(pixel);
      num_without += !ray;
      if (ray)
        EXPECT_LT((lens.Project(*ray, nullptr, 1).value() - pixel).norm(),
                  1e-6);
    }
  EXPECT_LE(num_without, 2);
}

TEST(OpenCvModel, FoldMovesWithTheParameters) {
  OpenCvModel lens = FoldingLens(-0.5);
  lens.SetParameters(FoldingLens(0).Parameters());
  EXPECT_TRUE(lens.Project({0.9, 0, 1}));
}

}  // namespace
}  // namespace raygrid
