#include "adjustment/prior_evidence.h"

#include <gtest/gtest.h>

#include <cmath>

namespace raygrid {
namespace {

// Parameters that scatter by a variance. Observations alone tell some of them
// with one error, and the others with another.
struct Scattered {
  double variance;
  double num_well, well, num_badly, badly;

  GroupEvidence Under(double prior_variance) const {
    GroupEvidence evidence = {num_well + num_badly, 0, 0};
    for (const auto& [num, error] : {std::pair(num_well, well * well),
                                     std::pair(num_badly, badly * badly)}) {
      const double told = prior_variance / (prior_variance + error);
      evidence.effective_parameters += num * told;
      evidence.squared_distance += num * told * told * (variance + error);
    }
    return evidence;
  }
};

constexpr double kResidualVariance = 0.01;

// How many rounds a weight needs, at most 30; *weight ends where it stands.
int NumRounds(const Scattered& scattered, double* weight) {
  VarianceUpdate update;
  int round = 0;
  double change = 1;
  while (change > 1e-3 && round < 30) {
    ++round;
    change = update.Update(scattered.Under(kResidualVariance / *weight),
                           kResidualVariance, 1e-12, weight);
  }
  return round;
}

TEST(VarianceUpdate, FindsAScatterAtOnce) {
  const Scattered alike = {4e-4, 500, 0.05, 0, 1};
  for (const double start : {1e-6, 1e-4, 4e-3}) {
    double weight = kResidualVariance / start;
    EXPECT_LE(NumRounds(alike, &weight), 4) << start;
    EXPECT_NEAR(kResidualVariance / weight, 4e-4, 1e-8) << start;
  }
}

TEST(VarianceUpdate, FindsAScatterThatIsToldBadlyOfMost) {
  // A step of all that parameters alike would need turns back, ever farther.
  const Scattered unlike = {4e-4, 50, 0.005, 450, 0.2};
  double weight = kResidualVariance / 4e-2;
  EXPECT_LT(NumRounds(unlike, &weight), 20);
  EXPECT_NEAR(kResidualVariance / weight, 4e-4, 4e-6);
}

TEST(VarianceUpdate, NoScatterSoonCountsForNothing) {
  const Scattered nominal = {0, 500, 0.05, 0, 1};
  double weight = kResidualVariance / (0.05 * 0.05);
  VarianceUpdate update;
  int round = 0;
  while (!IsUndetermined(nominal.Under(kResidualVariance / weight))) {
    update.Update(nominal.Under(kResidualVariance / weight), kResidualVariance,
                  1e-12, &weight);
    ASSERT_LT(++round, 4);
  }
}

TEST(VarianceUpdate, StopsAtTheSmallestVariance) {
  const Scattered nominal = {0, 500, 0.05, 0, 1};
  double weight = 1;
  NumRounds(nominal, &weight);
  EXPECT_LE(weight, kResidualVariance / 1e-12);
}

}  // namespace
}  // namespace raygrid
