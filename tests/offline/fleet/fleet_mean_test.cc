#include "fleet/fleet_mean.h"

#include <gtest/gtest.h>

#include "evaluation/model_difference.h"
#include "lens_family.h"

namespace raygrid {
namespace {

constexpr double kStepPx = 10;

CameraFile FileOf(const CameraModel& lens) {
  CameraFile file;
  file.camera = lens.Clone();
  return file;
}

// A third of the lenses are longer by twice what the others are shorter by.
std::vector<CameraFile> Units() {
  std::vector<CameraFile> files;
  for (int u = 0; u < 12; ++u)
    files.push_back(FileOf(LensFamily::Longer(u % 3 == 0 ? 0.004 : -0.002)));
  return files;
}

// By a median of each pixel it would be that of the shorter ones, which sees
// pixels up to 0.8 px from there.
TEST(ComputeMeanCamera, IsTheMeanOfWhatDiffersSmoothly) {
  const auto mean = ComputeMeanCamera(Units());
  ASSERT_TRUE(mean.has_value());
  EXPECT_LT(CompareModels(LensFamily::Mean(), *mean->camera, kStepPx).p99_px,
            0.03);
}

// 40 px in a corner that it saw nothing in.
TEST(ComputeMeanCamera, LeavesOutWhereAUnitGoesAstray) {
  std::vector<CameraFile> units = Units();
  units[1] = FileOf(LensFamily::Astray({600, 450}, {40, 0}, 60));
  const auto mean = ComputeMeanCamera(units);
  ASSERT_TRUE(mean.has_value());
  EXPECT_LT(CompareModels(LensFamily::Mean(), *mean->camera, kStepPx).p99_px,
            0.15);
}

TEST(ComputeMeanCamera, IsNoneOfNoUnits) {
  EXPECT_FALSE(ComputeMeanCamera({}).has_value());
}

}  // namespace
}  // namespace raygrid
