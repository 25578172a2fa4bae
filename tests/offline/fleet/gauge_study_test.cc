#include "fleet/gauge_study.h"

#include <gtest/gtest.h>

#include <cmath>

#include "simulation/random.h"

namespace raygrid {
namespace {

FleetInput MeasuredOnce(const std::vector<double>& focal_px) {
  FleetInput input;
  input.pixels.resize(static_cast<Eigen::Index>(focal_px.size()), 0);
  input.metrics = {{"focal_px", focal_px, false}};
  return input;
}

// A balanced study by the formulas of one factor: two operators, three repeats.
TEST(GaugeStudy, HasTheVariancesOfATextbook) {
  const FleetInput input = MeasuredOnce({1, 2, 3, 6, 7, 8});
  std::vector<GaugeRepeat> repeats;
  for (const char* person : {"ann", "ann", "ann", "bob", "bob", "bob"})
    repeats.push_back({"G", person, ""});
  const GaugeStudy study =
      StudyGauge(input, repeats, {}, {{"focal_px", {0, 30}}});
  ASSERT_EQ(study.metrics.size(), 1u);
  EXPECT_EQ(study.degrees_of_freedom, 4);
  EXPECT_EQ(study.num_goldens, 1);
  const GaugeMetric& metric = study.metrics[0];
  EXPECT_NEAR(metric.repeatability, 1, 1e-12);
  ASSERT_EQ(metric.factors.size(), 1u);
  EXPECT_EQ(metric.factors[0].name, "operator");
  // Mean squares between: 3 * 12.5 = 37.5, so the variance is 36.5 / 3.
  EXPECT_NEAR(metric.factors[0].deviation, std::sqrt(36.5 / 3), 1e-9);
  EXPECT_NEAR(metric.gauge, std::sqrt(1 + 36.5 / 3), 1e-9);
  EXPECT_NEAR(*metric.fraction_of_limits, 6 * metric.gauge / 30, 1e-9);
  EXPECT_FALSE(metric.fleet);
  EXPECT_TRUE(study.unobservable_reason.empty());
}

// Golden units, operators and stations that meet unevenly.
TEST(GaugeStudy, FindsTheVariancesThatItWasMadeOf) {
  constexpr int kStudies = 60;
  double of_repeats = 0, of_persons = 0, of_stations = 0;
  for (uint64_t seed = 1; seed <= kStudies; ++seed) {
    Random random(seed);
    std::vector<double> goldens(3), persons(6), stations(5), focal_px;
    for (double& value : goldens) value = 800 + 9 * random.Normal();
    for (double& value : persons) value = 0.3 * random.Normal();
    for (double& value : stations) value = 0.2 * random.Normal();
    std::vector<GaugeRepeat> repeats;
    for (int k = 0; k < 90; ++k) {
      const int golden = k * 7 % 3, person = k * 5 % 7 % 6,
                station = k * 3 % 11 % 5;
      repeats.push_back({std::to_string(golden), std::to_string(person),
                         std::to_string(station)});
      focal_px.push_back(goldens[golden] + persons[person] + stations[station] +
                         0.1 * random.Normal());
    }
    const GaugeStudy study =
        StudyGauge(MeasuredOnce(focal_px), repeats, {}, {});
    ASSERT_EQ(study.metrics.size(), 1u);
    const GaugeMetric& metric = study.metrics[0];
    ASSERT_EQ(metric.factors.size(), 2u);
    of_repeats += std::pow(metric.repeatability, 2) / kStudies;
    of_persons += std::pow(metric.factors[0].deviation, 2) / kStudies;
    of_stations += std::pow(metric.factors[1].deviation, 2) / kStudies;
  }
  EXPECT_NEAR(of_repeats, 0.01, 0.001);
  EXPECT_NEAR(of_persons, 0.09, 0.03);
  EXPECT_NEAR(of_stations, 0.04, 0.015);
}

TEST(GaugeStudy, IsAPartOfTheFleetsSpread) {
  Random random(4);
  FleetInput fleet = MeasuredOnce({});
  for (int u = 0; u < 400; ++u)
    fleet.metrics[0].values.push_back(800 + random.Normal());
  fleet.pixels = Eigen::MatrixXd::Zero(400, 0);
  std::vector<double> repeated;
  for (int k = 0; k < 200; ++k) repeated.push_back(0.2 * random.Normal());
  const GaugeStudy study =
      StudyGauge(MeasuredOnce(repeated),
                 std::vector<GaugeRepeat>(200, {"G", "", ""}), fleet, {});
  const GaugeMetric& metric = study.metrics.at(0);
  EXPECT_TRUE(metric.factors.empty());
  EXPECT_NEAR(*metric.fraction_of_fleet, 0.2, 0.04);
  EXPECT_NEAR(*metric.num_classes, 7, 1);
}

TEST(GaugeStudy, SaysWhatCannotBeTold) {
  const FleetInput input = MeasuredOnce({1, 2, 3, 4});
  // Each operator has a station alone.
  const GaugeStudy confounded = StudyGauge(input,
                                           {{"G", "ann", "s1"},
                                            {"G", "ann", "s1"},
                                            {"G", "bob", "s2"},
                                            {"G", "bob", "s2"}},
                                           {}, {});
  EXPECT_EQ(confounded.unobservable_reason.size(), 2u);
  EXPECT_TRUE(confounded.metrics.at(0).factors.empty());
  const GaugeStudy alone = StudyGauge(
      input, {{"G", "a", ""}, {"G", "b", ""}, {"G", "c", ""}, {"G", "d", ""}},
      {}, {});
  EXPECT_TRUE(alone.metrics.empty());
  ASSERT_EQ(alone.unobservable_reason.size(), 1u);
  EXPECT_NE(alone.unobservable_reason[0].find("no golden unit was repeated"),
            std::string::npos);
  EXPECT_EQ(StudyGauge(MeasuredOnce({}), {}, {}, {}).num_repeats, 0);
}

}  // namespace
}  // namespace raygrid
