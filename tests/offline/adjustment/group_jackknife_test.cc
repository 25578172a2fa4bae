#include "adjustment/group_jackknife.h"

#include "adjustment/bundle_adjustment.h"
#include "adjustment/covariance.h"
#include "small_problem.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr double kNoisePx = 0.1;

// White noise of each feature, and a displacement of each view that grows with
// the square of the distance on the board: no pose absorbs it.
SmallProblem WithNoise(SmallProblem problem, double correlated_px,
                       unsigned seed) {
  TestRandom random(seed);
  for (View& view : problem.views) {
    const Eigen::Vector2d direction = random.NormalVector<2>();
    for (Observation& o : view.observations) {
      const double distance_m = problem.state.points[o.point].head<2>().norm();
      o.pixel += kNoisePx * random.NormalVector<2>() +
                 correlated_px * distance_m * distance_m / 0.04 * direction;
    }
  }
  return problem;
}

SmallProblem AdjustedWith(const SmallProblem& exact, const GaussianPrior& prior,
                          double correlated_px, unsigned seed) {
  SmallProblem problem = WithNoise(exact, correlated_px, seed);
  RunBundleAdjustment(problem.views, prior, FixedPoints(), &problem.state);
  return problem;
}

// How some pixels move with the camera's parameters, but for a rotation.
Eigen::MatrixXd PixelMoves(const SmallProblem& problem) {
  std::vector<PixelUncertainty> pixels;
  std::vector<bool> is_known;
  Eigen::MatrixXd moves = ComputeLatticeJacobian(problem.views, problem.state,
                                                 0, {9, 7}, &pixels, &is_known);
  for (size_t i = 0; i < pixels.size(); ++i)
    if (pixels[i].num_observations == 0) moves.middleRows(2 * i, 2).setZero();
  return moves;
}

TEST(GroupJackknife, PredictsAdjustmentsWithoutEachGroup) {
  const SmallProblem exact = MakeExactGridProblem(20, 60);
  const GaussianPrior prior = WeakPrior(exact);
  const SmallProblem problem = AdjustedWith(exact, prior, 0, 5);
  const LinearResponse response(problem.views, prior, FixedPoints(),
                                problem.state);
  const GroupJackknife jackknife(response, problem.views, prior, FixedPoints(),
                                 problem.state, kNoisePx);
  ASSERT_TRUE(jackknife.IsValid());
  const Eigen::MatrixXd moves = PixelMoves(problem);
  const GroupJackknife::SquaredChanges changes = jackknife.Of(0, moves);
  const int num_groups = static_cast<int>(changes.observed.cols());
  ASSERT_EQ(num_groups, 16);
  for (const int group : {0, 9}) {
    AdjustmentState without = problem.state;
    std::vector<View> views;
    for (const View& view : problem.views)
      if (view.pose % num_groups != group) views.push_back(view);
    RunBundleAdjustment(views, prior, FixedPoints(), &without);
    const double squared_change =
        (moves *
         (without.camera().Parameters() - problem.state.camera().Parameters()))
            .squaredNorm();
    EXPECT_NEAR(changes.observed.col(group).sum(), squared_change,
                0.1 * squared_change);
  }
}

// The mean factor of draws of the noise.
double MeanFactor(double correlated_px) {
  constexpr int kNumDraws = 8;
  const SmallProblem exact = MakeExactGridProblem(24, 60);
  const GaussianPrior prior = WeakPrior(exact);
  double sum = 0;
  for (int draw = 0; draw < kNumDraws; ++draw) {
    const SmallProblem problem =
        AdjustedWith(exact, prior, correlated_px, 100 + draw);
    const LinearResponse response(problem.views, prior, FixedPoints(),
                                  problem.state);
    const GroupJackknife jackknife(response, problem.views, prior,
                                   FixedPoints(), problem.state, kNoisePx);
    sum += VarianceFactors(jackknife.Of(0, PixelMoves(problem))).overall_factor;
  }
  return sum / kNumDraws;
}

// A little below 1 with white noise, since the true camera is the prior's mean
// and not a draw from it.
TEST(GroupJackknife, SeesNoiseThatIsCorrelatedWithinViews) {
  const double white = MeanFactor(0);
  EXPECT_GT(white, 0.6);
  EXPECT_LT(white, 1.1);
  EXPECT_GT(MeanFactor(kNoisePx), 2 * white);
}

TEST(VarianceFactors, AreThoseOfTheBandAsFarAsItIsDetermined) {
  GroupJackknife::SquaredChanges changes;
  changes.predicted = Eigen::MatrixXd::Ones(63, 10);
  changes.observed = 4 * changes.predicted;
  changes.observed.row(0) *= 4;
  const Eigen::VectorXd factors = VarianceFactors(changes).group_factors;
  EXPECT_NEAR(factors[40], 4, 0.1);
  EXPECT_GT(factors[0], 6);  // ten squares say 16
  EXPECT_LT(factors[0], 14);
  changes.observed = changes.predicted;
  EXPECT_NEAR(VarianceFactors(changes).group_factors.mean(), 1, 0.05);
}

}  // namespace
}  // namespace raygrid
