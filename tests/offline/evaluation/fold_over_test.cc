#include "evaluation/fold_over.h"

#include <algorithm>
#include <vector>

#include "camera/central_generic.h"
#include "simulation/simulated_camera.h"
#include "support.h"

namespace raygrid {
namespace {

// A wide lens whose surface turns back left of a column of the image.
CentralGeneric FoldedLeftOf(double fold_px) {
  const Area area = {0, 0, 639, 479};
  std::vector<SurfaceSample> samples;
  for (int y = 0; y < 480; y += 12)
    for (int x = 0; x < 640; x += 12) {
      const double reach =
          x < fold_px ? 1 - 2 * (x - fold_px) : 1 + 2 * (x - fold_px);
      samples.push_back(
          {Eigen::Vector2d(x, y), {(reach - 500) / 800, (y - 240) / 400.0}});
    }
  return CentralGeneric({640, 480}, FitSurface(area, 67, 51, samples));
}

TEST(MeasureFoldOver, FindsNoneInALens) {
  EXPECT_EQ(MeasureFoldOver(ExampleSimulatedCamera(), nullptr).part, 0);
}

TEST(MeasureFoldOver, FindsAFoldedEdge) {
  const CentralGeneric camera = FoldedLeftOf(128);
  ValidityMask mask = ValidityMask::Over({640, 480});
  EXPECT_NEAR(MeasureFoldOver(camera, &mask).part, 0.2, 0.02);
  EXPECT_EQ(MeasureFoldOver(camera, &mask).valid_fraction, 0);
  EXPECT_EQ(MeasureFoldOver(camera, nullptr).valid_fraction, 0);
  // The upper half.
  std::fill_n(mask.is_valid.begin(), mask.columns * mask.rows / 2, true);
  EXPECT_NEAR(MeasureFoldOver(camera, &mask).valid_fraction, 0.1, 0.01);
}

TEST(MeasureFoldOver, CountsCellsOfAMirroredCameraTheOtherWayRound) {
  const CentralGeneric camera = FoldedLeftOf(512);
  EXPECT_NEAR(MeasureFoldOver(camera, nullptr).part, 0.2, 0.02);
}

}  // namespace
}  // namespace raygrid
