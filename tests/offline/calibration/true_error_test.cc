// A regression gate: the errors of calibrated cameras against the truth.

#include "true_error.h"

#include <cstdio>

#include "support.h"

namespace raygrid {
namespace {

// Means over three lenses of each kind, 20 images, noise 0.05 px.
// accuracy_bench has more of each.
struct Gate {
  const char *lens, *target;
  double rms_px;  ///< as it was measured
};

class TrueErrors : public testing::TestWithParam<Gate> {};

TEST_P(TrueErrors, DoNotGrow) {
  constexpr int kNumSeeds = 3;
  constexpr double kMargin = 1.05;
  TrueErrorSetting setting;
  setting.lens = GetParam().lens;
  setting.target = GetParam().target;
  setting.num_images = 20;
  double rms_px = 0, oracle_px = 0;
  for (int seed = 1; seed <= kNumSeeds; ++seed) {
    const TrueError error = MeasureTrueError(setting, seed);
    rms_px += error.rms_px / kNumSeeds;
    oracle_px += error.oracle_px / kNumSeeds;
  }
  std::printf("%s, %s target: RMS %.5f px, %.2f of the best possible\n",
              setting.lens.c_str(), setting.target.c_str(), rms_px,
              rms_px / oracle_px);
  EXPECT_LE(rms_px, kMargin * GetParam().rms_px);
  // Better than possible is a fault of the test.
  EXPECT_GE(rms_px, 0.75 * oracle_px);
}

INSTANTIATE_TEST_SUITE_P(, TrueErrors,
                         testing::Values(Gate{"wide", "flat", 0.0251},
                                         Gate{"narrow", "flat", 0.0172},
                                         Gate{"fisheye", "flat", 0.0187},
                                         Gate{"fisheye190", "flat", 0.0178},
                                         Gate{"smooth", "flat", 0.0190},
                                         Gate{"wide", "bent", 0.0443}));

}  // namespace
}  // namespace raygrid
