#include "fleet/fleet_statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "simulation/random.h"

namespace raygrid {
namespace {

// A lens of a family: focal length, centre and distortion scatter, and each
// calibration adds a smooth error of its own.
struct FamilyLens {
  double focal_px = 800, center_x_px = 640, center_y_px = 360, k1 = -0.2;
  double tilt_rad = 0;  // of the sensor, about its columns
};

class Family {
 public:
  explicit Family(uint64_t seed, double calibration_px = 0.03)
      : random_(seed), calibration_px_(calibration_px) {}

  FamilyLens Draw(double focal_px) {
    FamilyLens lens;
    lens.focal_px = focal_px * (1 + 0.003 * random_.Normal());
    lens.center_x_px += 3 * random_.Normal();
    lens.center_y_px += 3 * random_.Normal();
    lens.k1 += 0.004 * random_.Normal();
    return lens;
  }

  // The pixels that see 63 directions.
  Eigen::VectorXd PixelsOf(const FamilyLens& lens) {
    Eigen::VectorXd pixels(2 * kColumns * kRows);
    double error_px[4];
    for (double& error : error_px) error = calibration_px_ * random_.Normal();
    Eigen::Index at = 0;
    for (int j = 0; j < kRows; ++j)
      for (int i = 0; i < kColumns; ++i) {
        const double x = 1.4 * (i / (kColumns - 1.0) - 0.5);
        const double y = 0.8 * (j / (kRows - 1.0) - 0.5);
        const double factor = lens.focal_px * (1 + lens.k1 * (x * x + y * y));
        const double keystone = 1 + std::tan(lens.tilt_rad) * x;
        pixels[at++] = lens.center_x_px + factor * x / keystone +
                       error_px[0] * std::sin(3 * x + 2 * y) +
                       error_px[1] * std::cos(4 * y);
        pixels[at++] = lens.center_y_px + factor * y / keystone +
                       error_px[2] * std::sin(2 * x - 3 * y) +
                       error_px[3] * std::cos(5 * x);
      }
    return pixels;
  }

  FleetInput MakeFleet(const std::vector<FamilyLens>& lenses) {
    FleetInput fleet;
    fleet.pixels.resize(static_cast<Eigen::Index>(lenses.size()),
                        2 * kColumns * kRows);
    fleet.metrics = {{"focal_px", {}, false},
                     {"center_x_px", {}, false},
                     {"center_y_px", {}, false},
                     {"held_out_median_px", {}, true}};
    for (size_t u = 0; u < lenses.size(); ++u) {
      fleet.pixels.row(static_cast<Eigen::Index>(u)) = PixelsOf(lenses[u]);
      fleet.metrics[0].values.push_back(lenses[u].focal_px);
      fleet.metrics[1].values.push_back(lenses[u].center_x_px);
      fleet.metrics[2].values.push_back(lenses[u].center_y_px);
      fleet.metrics[3].values.push_back(0.03 *
                                        std::exp(0.2 * random_.Normal()));
    }
    return fleet;
  }

 private:
  static constexpr int kColumns = 9, kRows = 7;
  Random random_;
  double calibration_px_;
};

std::vector<int> UnusualUnits(const FleetStatistics& statistics) {
  std::vector<int> units;
  for (const OutlierUnit& outliers : statistics.outliers)
    units.push_back(outliers.unit);
  return units;
}

TEST(FleetStatistics, FindsTiltedSensorsAShiftedLensAndAJump) {
  int num_false_alarms = 0, num_false_jumps = 0;
  constexpr int kFleets = 10;
  for (uint64_t seed = 1; seed <= kFleets; ++seed) {
    Family family(seed);
    std::vector<FamilyLens> lenses;
    for (int u = 0; u < 200; ++u)
      lenses.push_back(family.Draw(u < 120 ? 800 : 803));
    for (const int tilted : {17, 88, 150}) lenses[tilted].tilt_rad = 0.005;
    lenses[61].center_x_px += 25;
    const FleetStatistics statistics = FindOutliers(family.MakeFleet(lenses));
    const std::vector<int> units = UnusualUnits(statistics);
    for (const int wanted : {17, 61, 88, 150})
      EXPECT_EQ(std::count(units.begin(), units.end(), wanted), 1)
          << seed << " " << wanted;
    num_false_alarms += static_cast<int>(units.size()) - 4;
    bool is_jump_found = false;
    for (const MeanJump& jump : statistics.jumps) {
      const bool is_focal = jump.name == "focal_px";
      if (!is_focal && jump.name != "lens") {
        ++num_false_jumps;
        continue;
      }
      EXPECT_NEAR(jump.unit, 120, 12) << seed;
      if (is_focal) {
        EXPECT_NEAR(jump.after - jump.before, 3, 1.5) << seed;
      }
      is_jump_found |= is_focal;
    }
    EXPECT_TRUE(is_jump_found) << seed;
  }
  RecordProperty("false_alarms", num_false_alarms);
  RecordProperty("false_jumps", num_false_jumps);
  EXPECT_LE(num_false_alarms, kFleets / 2);
  EXPECT_LE(num_false_jumps, kFleets / 5);
}

// Lenses scatter by a thousand times as much as calibrations are wrong by. A
// middle that is none of the lenses would be a shape of all units, and hide
// those of others.
TEST(FleetStatistics, FindsSmallTiltsByGoodCalibrations) {
  constexpr int kFleets = 5;
  int num_false_alarms = 0;
  for (uint64_t seed = 1; seed <= kFleets; ++seed) {
    Family family(seed, 0.003);
    std::vector<FamilyLens> lenses;
    for (int u = 0; u < 200; ++u)
      lenses.push_back(family.Draw(u < 120 ? 800 : 803));
    for (const int tilted : {17, 88, 150}) lenses[tilted].tilt_rad = 0.0003;
    const std::vector<int> units =
        UnusualUnits(FindOutliers(family.MakeFleet(lenses)));
    for (const int wanted : {17, 88, 150})
      EXPECT_EQ(std::count(units.begin(), units.end(), wanted), 1)
          << seed << " " << wanted;
    num_false_alarms += static_cast<int>(units.size()) - 3;
  }
  EXPECT_LE(num_false_alarms, 2);
}

// One tilted sensor of few new units pulls their mean so far that all of them
// seem unusual.
TEST(FleetStatistics, NamesOneOfAFewNewUnitsAndNotAll) {
  constexpr int kFleets = 10, kUnits = 100, kNew = 6, kTilted = 96;
  int num_found = 0, num_false_alarms = 0;
  for (uint64_t seed = 1; seed <= kFleets; ++seed) {
    Family family(seed, 0.01);
    std::vector<FamilyLens> lenses;
    for (int u = 0; u < kUnits; ++u)
      lenses.push_back(family.Draw(u < kUnits - kNew ? 800 : 820));
    lenses[kTilted].tilt_rad = 0.005;
    for (const int unit : UnusualUnits(FindOutliers(family.MakeFleet(lenses))))
      ++(unit == kTilted ? num_found : num_false_alarms);
  }
  EXPECT_EQ(num_found, kFleets);
  EXPECT_LE(num_false_alarms, 2);
}

// One tilted sensor of few units is a direction in which lenses vary, by
// itself: no unit of the fleet is as far off as a new one may be.
TEST(FleetStatistics, FindsATiltedSensorOfFewUnits) {
  constexpr int kFleets = 10;
  int num_false_alarms = 0;
  for (const double tilt_rad : {0.005, 0.01, 0.02}) {
    for (uint64_t seed = 1; seed <= kFleets; ++seed) {
      Family family(seed);
      std::vector<FamilyLens> lenses;
      for (int u = 0; u < 40; ++u) lenses.push_back(family.Draw(800));
      lenses[17].tilt_rad = tilt_rad;
      const std::vector<int> units =
          UnusualUnits(FindOutliers(family.MakeFleet(lenses)));
      EXPECT_EQ(std::count(units.begin(), units.end(), 17), 1)
          << seed << ", tilted by " << tilt_rad;
      num_false_alarms += static_cast<int>(units.size()) - 1;
    }
  }
  EXPECT_LE(num_false_alarms, kFleets / 5);
}

TEST(FleetStatistics, SeldomGivesAnAlarmWhereNothingIsUnusual) {
  int num_alarms = 0, num_changes = 0;
  constexpr int kFleets = 200;
  for (uint64_t seed = 100; seed < 100 + kFleets; ++seed) {
    Family family(seed);
    std::vector<FamilyLens> lenses;
    for (int u = 0; u < 100; ++u) lenses.push_back(family.Draw(800));
    const FleetStatistics statistics = FindOutliers(family.MakeFleet(lenses));
    num_alarms += !statistics.outliers.empty();
    num_changes += !statistics.jumps.empty() || !statistics.drifts.empty();
    EXPECT_GE(statistics.num_directions, 2);
    EXPECT_LE(statistics.num_directions, 8);
  }
  RecordProperty("alarms", num_alarms);
  RecordProperty("changes", num_changes);
  // 10 of each are to be expected.
  EXPECT_LE(num_alarms, 16);
  EXPECT_LE(num_changes, 16);
}

TEST(FleetStatistics, HasNoLimitsOfAFewUnits) {
  Family family(3);
  const std::vector<FamilyLens> lenses(kMinFleetUnits - 1);
  const FleetStatistics statistics = FindOutliers(family.MakeFleet(lenses));
  EXPECT_TRUE(statistics.charts.empty());
  EXPECT_TRUE(statistics.outliers.empty());
  EXPECT_TRUE(statistics.jumps.empty());
}

// A figure that some units have not is compared where it is known.
TEST(FleetStatistics, LeavesOutWhatIsNotKnown) {
  Family family(4);
  std::vector<FamilyLens> lenses;
  for (int u = 0; u < 40; ++u) lenses.push_back(family.Draw(800));
  FleetInput fleet = family.MakeFleet(lenses);
  FleetMetric temperature{"sensor_temperature_c", {}, false};
  for (int u = 0; u < 40; ++u)
    temperature.values.push_back(u % 3 == 0
                                     ? std::numeric_limits<double>::quiet_NaN()
                                     : 40 + 0.1 * (u * 7 % 11));
  temperature.values[31] = 60;
  fleet.metrics.push_back(temperature);
  const FleetStatistics statistics = FindOutliers(fleet);
  ASSERT_EQ(statistics.outliers.size(), 1u);
  EXPECT_EQ(statistics.outliers[0].unit, 31);
  EXPECT_EQ(statistics.outliers[0].charts,
            std::vector<std::string>{"sensor_temperature_c"});
}

}  // namespace
}  // namespace raygrid
