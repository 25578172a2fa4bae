#include "fleet/lens_batches.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "simulation/random.h"

namespace raygrid {
namespace {

constexpr int kBatchSize = 20;

// Units in three batches, one behind the other. Lenses vary along two
// directions; the last batch is moved along one, and so is its focal length.
FleetInput MakeBatches(uint64_t seed, double moved) {
  Random random(seed);
  FleetInput fleet;
  const int count = 3 * kBatchSize;
  fleet.pixels = Eigen::MatrixXd::Zero(count, 12);
  fleet.metrics = {{"focal_px", {}, false}, {"held_out_median_px", {}, true}};
  for (int u = 0; u < count; ++u) {
    const double first = random.Normal() + (u >= 2 * kBatchSize ? moved : 0),
                 second = random.Normal();
    for (int k = 0; k < 12; ++k)
      fleet.pixels(u, k) =
          100 + first * k / 10 + second * (k % 3) + 0.001 * random.Normal();
    fleet.metrics[0].values.push_back(800 + first);
    fleet.metrics[1].values.push_back(0.03 * std::exp(0.2 * random.Normal()));
  }
  return fleet;
}

std::vector<std::string> NamesOfBatches() {
  std::vector<std::string> names;
  for (const char* name : {"a", "b", "c"})
    names.insert(names.end(), kBatchSize, name);
  return names;
}

TEST(LensBatches, DifferInWhatWasMoved) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const BatchComparison comparison =
        CompareLensBatches(MakeBatches(seed, 2.5), NamesOfBatches(), {});
    EXPECT_EQ(comparison.batches, (std::vector<std::string>{"a", "b", "c"}));
    ASSERT_EQ(comparison.metrics.size(), 3u);
    EXPECT_EQ(comparison.metrics[0].name, "lens");
    EXPECT_TRUE(comparison.metrics[0].differs) << seed;
    EXPECT_TRUE(comparison.metrics[1].differs) << seed;
    EXPECT_NEAR(comparison.metrics[1].means[2] - 802.5, 0, 0.9) << seed;
    EXPECT_NEAR(comparison.metrics[1].within_batch_stddev, 1, 0.35) << seed;
    EXPECT_FALSE(comparison.metrics[2].differs) << seed;
    EXPECT_NEAR(comparison.metrics[2].means[0], 0.03, 0.006) << seed;
  }
}

TEST(LensBatches, EqualOnesSeldomDiffer) {
  int num_different = 0, num_even[3] = {0, 0, 0};
  constexpr int kFleets = 400;
  for (uint64_t seed = 1; seed <= kFleets; ++seed) {
    const BatchComparison comparison =
        CompareLensBatches(MakeBatches(seed, 0), NamesOfBatches(), {});
    bool differs = false;
    for (int k = 0; k < 3; ++k) {
      differs |= comparison.metrics[k].differs;
      num_even[k] += comparison.metrics[k].p_value < 0.5;
    }
    num_different += differs;
  }
  RecordProperty("different", num_different);
  // 20 are to be expected, and a chance below one half in half of the fleets.
  EXPECT_LE(num_different, 32);
  EXPECT_GE(num_different, 6);
  for (const int even : num_even) EXPECT_NEAR(even, kFleets / 2, 40);
}

// The F of three groups by hand: means 2, 3, 7 of three values each.
TEST(LensBatches, HaveTheChanceOfATextbook) {
  FleetInput fleet;
  fleet.pixels = Eigen::MatrixXd::Random(9, 4);
  fleet.metrics = {{"focal_px", {1, 2, 3, 2, 3, 4, 6, 7, 8}, false}};
  const BatchComparison comparison = CompareLensBatches(
      fleet, {"a", "a", "a", "b", "b", "b", "c", "c", "c"}, {});
  // Between 42 / 2, within 6 / 6: F(2, 6) = 21. With two degrees of freedom,
  // its chance is (1 + 2 F / 6)^-3.
  EXPECT_NEAR(comparison.metrics[1].p_value, std::pow(8, -3), 1e-12);
  EXPECT_NEAR(comparison.metrics[1].within_batch_stddev, 1, 1e-12);
}

TEST(LensBatches, LeaveOutOutliersUnknownOnesAndSmallBatches) {
  FleetInput fleet = MakeBatches(5, 0);
  std::vector<std::string> names = NamesOfBatches();
  names[0] = "tiny";
  names[1] = "";
  fleet.metrics[0].values[25] = 1e6;
  fleet.metrics[0].values[26] = std::numeric_limits<double>::quiet_NaN();
  const BatchComparison comparison =
      CompareLensBatches(fleet, names, {{25, {"focal_px"}}});
  EXPECT_EQ(comparison.batches, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(comparison.num_units, (std::vector<int>{18, 19, 20}));
  EXPECT_NEAR(comparison.metrics[1].means[1], 800, 1);
  EXPECT_TRUE(CompareLensBatches(fleet, std::vector<std::string>(60, "a"), {})
                  .batches.empty());
}

}  // namespace
}  // namespace raygrid
