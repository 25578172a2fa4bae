#include "fleet/mean_changes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "simulation/random.h"

namespace raygrid {
namespace {

using UnitSeries = std::vector<std::vector<double>>;

// Series of noise, each moved by an offset at each unit.
template <typename Offset>
UnitSeries MakeSeries(int count, int size, uint64_t seed, Offset offset) {
  Random random(seed);
  UnitSeries series(size);
  for (std::vector<double>& values : series)
    for (int u = 0; u < count; ++u)
      values.push_back(7 + 0.5 * (random.Normal() + offset(u)));
  return series;
}

TEST(MeanChanges, TellsADriftFromAJump) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const UnitSeries drifting =
        MakeSeries(200, 2, seed, [](int u) { return 2 * u / 200.0; });
    const MeanChanges drift = FindMeanChanges(drifting, 0.05);
    ASSERT_EQ(drift.drifts.size(), 1u) << seed;
    EXPECT_TRUE(drift.jumps.empty()) << seed;
    const std::vector<double> line = ComputeCenterLine(drifting[0], drift);
    EXPECT_NEAR(line.back() - line.front(), 1, 0.4) << seed;

    const UnitSeries jumping =
        MakeSeries(200, 2, seed, [](int u) { return u < 120 ? 0 : 3; });
    const MeanChanges jump = FindMeanChanges(jumping, 0.05);
    ASSERT_EQ(jump.jumps.size(), 1u) << seed;
    EXPECT_TRUE(jump.drifts.empty()) << seed;
    EXPECT_NEAR(jump.jumps[0].unit, 120, 5) << seed;
    const std::vector<double> center_line = ComputeCenterLine(jumping[0], jump);
    EXPECT_NEAR(center_line.back() - center_line.front(), 1.5, 0.35) << seed;
  }
}

TEST(MeanChanges, ChangesSeldomWhereNothingChanges) {
  int num_jumps = 0, num_drifts = 0;
  for (uint64_t seed = 1; seed <= 400; ++seed) {
    const MeanChanges changes =
        FindMeanChanges(MakeSeries(100, 3, seed, [](int) { return 0; }), 0.05);
    num_jumps += !changes.jumps.empty();
    num_drifts += !changes.drifts.empty();
  }
  RecordProperty("jumps", num_jumps);
  RecordProperty("drifts", num_drifts);
  // 10 of each are to be expected, at most.
  EXPECT_LE(num_jumps, 16);
  EXPECT_LE(num_drifts, 16);
}

TEST(MeanChanges, LeaveUnknownValuesAndOutliersOut) {
  UnitSeries series = MakeSeries(60, 1, 3, [](int) { return 0; });
  for (int u = 0; u < 60; u += 4) series[0][u] = std::nan("");
  series[0][31] = 100;
  const MeanChanges changes = FindMeanChanges(series, 0.05);
  EXPECT_TRUE(changes.jumps.empty());
  EXPECT_TRUE(changes.drifts.empty());
}

}  // namespace
}  // namespace raygrid
