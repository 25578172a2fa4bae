#include "evaluation/cross_fit.h"

#include <numeric>
#include <utility>

#include "support.h"

namespace raygrid {
namespace {

// Ten units of 40 features, each with a shift of its own.
LinearCauseModel ShiftsOfUnits() {
  LinearCauseModel cause;
  cause.num_units = 10;
  cause.columns.resize(2, 800);
  for (int i = 0; i < 400; ++i) {
    cause.unit.push_back(i % 10);
    cause.half.push_back(i / 10 % 2);
    cause.columns.middleCols<2>(2 * i).setIdentity();
  }
  return cause;
}

Eigen::VectorXd EstimateNoise(unsigned seed) {
  TestRandom random(seed);
  Eigen::VectorXd errors(800);
  for (Eigen::Index i = 0; i < errors.size(); ++i) errors[i] = random.Normal();
  return errors;
}

// The part of squared errors that all units together explain.
double ExplainedPart(const CrossFit& fit, const Eigen::VectorXd& errors) {
  const std::vector<double> explained = ComputeExplainedSquares(
      fit, {errors, errors}, {fit.Predict(0, errors), fit.Predict(1, errors)});
  return std::accumulate(explained.begin(), explained.end(), 0.0) /
         errors.squaredNorm();
}

TEST(CrossFit, PredictsShiftsFromTheOtherHalf) {
  const CrossFit fit(ShiftsOfUnits());
  Eigen::VectorXd errors = 0.1 * EstimateNoise(1);
  for (int i = 0; i < 400; ++i) errors[2 * i] += i % 10;
  for (int half = 0; half < 2; ++half) {
    const Eigen::VectorXd predicted = fit.Predict(half, errors);
    for (int i = 0; i < 400; ++i) {
      EXPECT_NEAR(predicted[2 * i], i % 10, 0.3);
      EXPECT_NEAR(predicted[2 * i + 1], 0, 0.3);
    }
  }
  EXPECT_NEAR(ExplainedPart(fit, errors), 1, 0.01);
}

TEST(CrossFit, PredictsNextToNothingFromNoise) {
  const CrossFit fit(ShiftsOfUnits());
  for (unsigned seed = 1; seed <= 10; ++seed) {
    EXPECT_NEAR(ExplainedPart(fit, EstimateNoise(seed)), 0, 0.05);
  }
}

TEST(CrossFit, LeavesFeaturesOfNoUnitAlone) {
  LinearCauseModel cause = ShiftsOfUnits();
  cause.unit[7] = -1;
  const CrossFit fit(std::move(cause));
  Eigen::VectorXd errors = Eigen::VectorXd::Constant(800, 3);
  EXPECT_EQ(fit.Predict(0, errors).segment<2>(14).norm(), 0);
  errors.segment<2>(14).setConstant(1e9);
  EXPECT_LT(fit.Predict(0, errors).norm(), 1e3);
}

}  // namespace
}  // namespace raygrid
