// A regression gate: the errors of calibrated cameras against the truth.

#include "true_error.h"

#include <cstdio>

#include "support.h"

namespace raygrid {
namespace {

// Lenses of each kind, 20 images, noise 0.05 px. accuracy_bench has more of
// each.
struct Gate {
  const char *lens, *target;
  double first_rms_px, mean_rms_px;  ///< as they were measured
};

class TrueErrors : public testing::TestWithParam<Gate> {};

constexpr double kMargin = 1.05;

// Means over the lenses of the first seeds.
TrueError MeasureLenses(const Gate& gate, int num_lenses, bool with_oracle) {
  TrueErrorSetting setting;
  setting.lens = gate.lens;
  setting.target = gate.target;
  setting.num_images = 20;
  setting.with_oracle = with_oracle;
  TrueError mean;
  for (int seed = 1; seed <= num_lenses; ++seed) {
    const TrueError error = MeasureTrueError(setting, seed);
    mean.rms_px += error.rms_px / num_lenses;
    mean.oracle_px += error.oracle_px / num_lenses;
  }
  std::printf("%s, %s target: RMS %.5f px\n", setting.lens.c_str(),
              setting.target.c_str(), mean.rms_px);
  return mean;
}

TEST_P(TrueErrors, OfOneLensDoNotGrow) {
  EXPECT_LE(MeasureLenses(GetParam(), 1, false).rms_px,
            kMargin * GetParam().first_rms_px);
}

TEST_P(TrueErrors, OfThreeLensesDoNotGrow) {
  const TrueError mean = MeasureLenses(GetParam(), 3, true);
  std::printf("%.2f of the best possible\n", mean.rms_px / mean.oracle_px);
  EXPECT_LE(mean.rms_px, kMargin * GetParam().mean_rms_px);
  // Better than possible is a fault of the test.
  EXPECT_GE(mean.rms_px, 0.75 * mean.oracle_px);
}

INSTANTIATE_TEST_SUITE_P(
    , TrueErrors,
    testing::Values(Gate{"wide", "flat", 0.0241, 0.0251},
                    Gate{"narrow", "flat", 0.0193, 0.0172},
                    Gate{"fisheye", "flat", 0.0141, 0.0187},
                    Gate{"fisheye190", "flat", 0.0143, 0.0178},
                    Gate{"smooth", "flat", 0.0144, 0.0190},
                    Gate{"wide", "bent", 0.0362, 0.0443}));

}  // namespace
}  // namespace raygrid
