#include "camera/opencv.h"
#include "simulation/bumpy_camera.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr ImageSize kBumpySize = {320, 240};
constexpr Area kBumpyArea = {-1, -1, 320, 240};

OpenCvModel LensBehindBumps() {
  return OpenCvModel(
      kBumpySize, {-51, -51, 370, 290},
      {265, 266, 161, 118, -0.28, 0.09, 0, 0, 0, 0, 7e-4, -4e-4});
}

TEST(BumpyCamera, ProjectionInvertsLines) {
  const BumpyCamera lens(LensBehindBumps(), kBumpyArea, {20, 0.2, 2e-4, 1});
  EXPECT_FALSE(lens.IsCentral());
  TestRandom random(1);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(WholeImage(kBumpySize));
    const ObservationLine line = lens.Line(pixel).value();
    const double distance_m = random.Uniform(0.2, 3);
    const auto found =
        lens.Project(line.origin + distance_m * line.direction, nullptr, 0);
    ASSERT_TRUE(found);
    EXPECT_LT((*found - pixel).norm(), 1e-8);
  }
}

TEST(BumpyCamera, HasBumpsOfItsHeightAllOverTheImage) {
  for (const double width_px : {20.0, 40.0, 60.0}) {
    const BumpyCamera lens(LensBehindBumps(), kBumpyArea,
                           {width_px, 0.2, 0, 1});
    // Each square of the lattice has a place where a bump is highest.
    const double side = 2 * width_px;
    for (double y = -1; y + side <= 240; y += side)
      for (double x = -1; x + side <= 320; x += side) {
        double highest = 0;
        for (double v = y; v < y + side; ++v)
          for (double u = x; u < x + side; ++u)
            highest = std::max(highest, lens.ComputeShift({u, v}).norm());
        EXPECT_GT(highest, 0.15);
        EXPECT_LT(highest, 0.3);
      }
  }
}

TEST(BumpyCamera, HasBumpsAsWideAsAskedAtHalfTheirHeight) {
  constexpr double kWidthPx = 200;  // one bump in the image
  const BumpyCamera lens(LensBehindBumps(), kBumpyArea, {kWidthPx, 1, 0, 3});
  Eigen::Vector2d top(0, 0);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x)
      if (lens.ComputeShift(Eigen::Vector2d(x, y)).norm() >
          lens.ComputeShift(top).norm())
        top = {x, y};
  const double there = lens.ComputeShift(top).norm();
  EXPECT_NEAR(there, 1, 0.05);
  EXPECT_NEAR(lens.ComputeShift(top - Eigen::Vector2d(kWidthPx / 2, 0)).norm(),
              there / 2, 0.05);
}

TEST(BumpyCamera, ShiftsWithoutAJumpWhereBumpsBeginToCount) {
  const BumpyCamera lens(LensBehindBumps(), kBumpyArea, {20, 0.2, 0, 1});
  for (int y = 0; y < 240; y += 7)
    for (double x = 39; x < 319; x += 40)  // the lattice's lines
      EXPECT_LT((lens.ComputeShift({x + 1e-9, double(y)}) -
                 lens.ComputeShift({x - 1e-9, double(y)}))
                    .norm(),
                1e-7);
}

}  // namespace
}  // namespace raygrid
