#include "adjustment/shared_noise.h"

#include "adjustment/covariance.h"
#include "small_problem.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr double kOwnPx = 0.1;

// Views of a camera with a coarse grid, exactly, and a weak prior.
struct ExactViews {
  SmallProblem problem = MakeExactGridProblem(40, 90);
  GaussianPrior prior;
  AdjustmentOptions options;

  ExactViews() {
    prior.cameras = {WeakGridPrior(problem)};
    options.fix_points = true;
    options.num_threads = 1;
  }
  LinearResponse Response() const {
    return {problem.views, prior, options, problem.state};
  }
  // An adjustment to such noise.
  SmallProblem Adjusted(const std::vector<SmoothField>& fields, double own_px,
                        double shared_px, int seed) const {
    SmallProblem noisy = problem;
    TestRandom random(seed);
    std::mt19937 random_bits(seed);
    for (size_t v = 0; v < noisy.views.size(); ++v) {
      const Eigen::Matrix2Xd shared = fields[v].Draw(&random_bits);
      for (size_t i = 0; i < noisy.views[v].observations.size(); ++i)
        noisy.views[v].observations[i].pixel +=
            own_px * random.NormalVector<2>() +
            shared_px * shared.col(static_cast<Eigen::Index>(i));
    }
    AdjustBundle(noisy.views, prior, options, &noisy.state);
    return noisy;
  }
  ObservationNoise NoiseOf(const SmallProblem& noisy, double noise_px,
                           int max_exact_unknowns = 2500) const {
    const LinearResponse response(noisy.views, prior, options, noisy.state,
                                  max_exact_unknowns);
    return MeasureNoise(
        response, noisy.state, 0, response.layout().first_camera[0],
        MovesOfSeenPixels(noisy.views, noisy.state, 0), noise_px);
  }
};

TEST(SmoothField, IsAlikeWithinItsLength) {
  constexpr double kLength = 4;
  constexpr int kDraws = 2000;
  Eigen::Matrix2Xd places(2, 4);
  places << 0, 3, 0, 4.3,  //
      0, 0, 4, 7.1;
  const SmoothField field(places, kLength);
  std::mt19937 random_bits(1);
  Eigen::Matrix4d x = Eigen::Matrix4d::Zero(), y = x, cross = x;
  for (int k = 0; k < kDraws; ++k) {
    const Eigen::Matrix2Xd drawn = field.Draw(&random_bits);
    x += drawn.row(0).transpose() * drawn.row(0) / kDraws;
    y += drawn.row(1).transpose() * drawn.row(1) / kDraws;
    cross += drawn.row(0).transpose() * drawn.row(1) / kDraws;
  }
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 4; ++k) {
      const double d2 = (places.col(i) - places.col(k)).squaredNorm();
      const double expected = std::exp(-d2 / (2 * kLength * kLength));
      EXPECT_NEAR(x(i, k), expected, 0.1);
      EXPECT_NEAR(y(i, k), expected, 0.1);
      EXPECT_NEAR(cross(i, k), 0, 0.1);
    }
}

TEST(SmoothField, TellsTheVarianceOfWeightedDisplacements) {
  constexpr double kLength = 4;
  Eigen::Matrix2Xd places(2, 4), weights(2, 4);
  places << 0, 3, 0, 4.3,  //
      0, 0, 4, 7.1;
  weights << 1, -2, 0.5, 0,  //
      0, 1, 1, -3;
  double expected = 0;
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 4; ++k)
      expected += weights.col(i).dot(weights.col(k)) *
                  std::exp(-(places.col(i) - places.col(k)).squaredNorm() /
                           (2 * kLength * kLength));
  EXPECT_NEAR(SmoothField(places, kLength).VarianceOf(weights), expected,
              0.02 * expected);
}

TEST(MeasureNoise, FindsNoSharedPartInWhiteNoise) {
  const ExactViews exact;
  const auto fields =
      SmoothFields(exact.Response(), exact.problem.state.points, 4);
  const ObservationNoise noise =
      exact.NoiseOf(exact.Adjusted(fields, kOwnPx, 0, 5), kOwnPx);
  EXPECT_NEAR(noise.own_px, kOwnPx, 0.03 * kOwnPx);
  EXPECT_LT(noise.SharedPx(), 0.25 * kOwnPx);
}

TEST(MeasureNoise, IsWhiteWhereFeaturesAreExact) {
  const ExactViews exact;
  const ObservationNoise noise = exact.NoiseOf(exact.problem, kOwnPx);
  EXPECT_EQ(noise.own_px, kOwnPx);
  EXPECT_TRUE(noise.shared.empty());
}

// A typical standard deviation of what is seen, by noise.
double TypicalPx(const ExactViews& exact, const ObservationNoise& noise) {
  double sum = 0, count = 0;
  for (const PixelUncertainty& pixel :
       ProjectionUncertainty(exact.Response(), noise, exact.problem.views,
                             exact.problem.state, 0, {9, 7, 128})) {
    if (pixel.num_observations < 3) continue;
    sum += std::log(pixel.noise_px2.trace()) / 2;
    ++count;
  }
  return std::exp(sum / count);
}

TEST(MeasureNoise, FindsWhatSharedNoiseDoes) {
  constexpr int kSeeds = 4;
  const ExactViews exact;
  for (const double length : {2.0, 8.0}) {
    const auto fields =
        SmoothFields(exact.Response(), exact.problem.state.points, length);
    const ObservationNoise truth = {1.3 * kOwnPx, kOwnPx, {{length, kOwnPx}}};
    double own = 0, effect = 0, iterated = 0;
    for (int seed = 0; seed < kSeeds; ++seed) {
      const SmallProblem noisy =
          exact.Adjusted(fields, kOwnPx, kOwnPx, 6 + seed);
      const ObservationNoise found = exact.NoiseOf(noisy, truth.total_px);
      own += found.own_px / kSeeds;
      effect += TypicalPx(exact, found) / kSeeds;
      if (seed > 0) continue;
      // Without a factor, from fewer draws.
      iterated = TypicalPx(exact, exact.NoiseOf(noisy, truth.total_px, 0)) /
                 TypicalPx(exact, found);
    }
    EXPECT_NEAR(own, kOwnPx, 0.15 * kOwnPx);
    EXPECT_NEAR(effect / TypicalPx(exact, truth), 1, 0.2);
    EXPECT_NEAR(iterated, 1, 0.3);
    EXPECT_GT(TypicalPx(exact, truth),
              1.3 * TypicalPx(exact, {1.3 * kOwnPx, 1.3 * kOwnPx, {}}));
  }
}

// Few views, of which two see all features, the others every sixth or so.
ExactViews UnequalViews(int num_views) {
  ExactViews exact;
  exact.problem = MakeExactGridProblem(num_views, 90);
  exact.prior.cameras = {WeakGridPrior(exact.problem)};
  for (int v = 2; v < num_views; ++v) {
    std::vector<Observation> some;
    for (size_t i = v % 3; i < 90; i += 6)
      some.push_back(exact.problem.views[v].observations[i]);
    exact.problem.views[v].observations = some;
  }
  return exact;
}

TEST(MeasureNoise, SeldomFindsSharedPartInWhiteNoiseOfFewUnequalViews) {
  constexpr int kDraws = 60;
  int num_alarms = 0, num_all = 0;
  for (const int num_views : {5, 6, 10, 20}) {
    const ExactViews exact = UnequalViews(num_views);
    const auto fields =
        SmoothFields(exact.Response(), exact.problem.state.points, 4);
    const double truth_px = TypicalPx(exact, {kOwnPx, kOwnPx, {}});
    for (int draw = 0; draw < kDraws; ++draw) {
      const ObservationNoise found =
          exact.NoiseOf(exact.Adjusted(fields, kOwnPx, 0, 1000 + draw), kOwnPx);
      num_alarms += TypicalPx(exact, found) > 1.25 * truth_px;
      ++num_all;
    }
  }
  EXPECT_LE(num_alarms, num_all / 6);
}

TEST(MeasureNoise, FindsSharedPartOfManyUnequalViews) {
  constexpr int kDraws = 10;
  const ExactViews exact = UnequalViews(60);
  const auto fields =
      SmoothFields(exact.Response(), exact.problem.state.points, 4);
  const double truth_px = TypicalPx(exact, {kOwnPx, kOwnPx, {{4, kOwnPx}}});
  ASSERT_GT(truth_px, 1.5 * TypicalPx(exact, {kOwnPx, kOwnPx, {}}));
  double mean_px = 0;
  for (int draw = 0; draw < kDraws; ++draw)
    mean_px += TypicalPx(exact, exact.NoiseOf(exact.Adjusted(fields, kOwnPx,
                                                             kOwnPx, 50 + draw),
                                              1.3 * kOwnPx)) /
               kDraws;
  EXPECT_NEAR(mean_px / truth_px, 1, 0.2);
}

TEST(MeasureNoise, IsWhatAdjustedCamerasScatterWith) {
  constexpr int kNumDraws = 30;
  const ExactViews exact;
  const UncertaintyOptions lattice = {9, 7, 256};
  const LinearResponse response = exact.Response();
  const auto fields = SmoothFields(response, exact.problem.state.points, 8);
  // How pixels move, the rotation apart, which the weak prior hardly holds:
  // over the image's middle, all cameras are turned alike.
  const auto predict = [&](const ObservationNoise& noise) {
    return ProjectionUncertainty(response, noise, exact.problem.views,
                                 exact.problem.state, 0, lattice);
  };
  const auto white = predict({kOwnPx, kOwnPx, {}});
  const auto both = predict({kOwnPx, kOwnPx, {{8, kOwnPx}}});
  double found = 0, by_white = 0, by_both = 0;
  std::vector<SmallProblem> adjusted;
  for (int draw = 0; draw < kNumDraws; ++draw)
    adjusted.push_back(exact.Adjusted(fields, kOwnPx, kOwnPx, 100 + draw));
  std::vector<size_t> seen;
  for (size_t i = 0; i < both.size(); ++i)
    if (both[i].num_observations >= 3) seen.push_back(i);
  ASSERT_GT(seen.size(), 10u);
  for (const SmallProblem& noisy : adjusted) {
    const Eigen::Index size = 2 * static_cast<Eigen::Index>(seen.size());
    Eigen::VectorXd errors(size);
    Eigen::MatrixX3d by_rotation(size, 3), weighted(size, 3);
    for (size_t k = 0; k < seen.size(); ++k) {
      const Eigen::Index row = 2 * static_cast<Eigen::Index>(k);
      const Eigen::Vector2d& pixel = both[seen[k]].pixel;
      const Eigen::Vector3d ray =
          exact.problem.state.camera().Unproject(pixel).value();
      errors.segment<2>(row) =
          noisy.state.camera().Project(ray, &pixel, 50).value() - pixel;
      LinearizedProjection linear;
      ASSERT_TRUE(
          exact.problem.state.camera().Linearize(ray, &pixel, 1, &linear));
      Eigen::Matrix3d minus_cross;
      minus_cross << 0, ray.z(), -ray.y(), -ray.z(), 0, ray.x(), ray.y(),
          -ray.x(), 0;
      by_rotation.middleRows<2>(row) = linear.by_point * minus_cross;
      weighted.middleRows<2>(row) =
          both[seen[k]].num_observations * by_rotation.middleRows<2>(row);
    }
    errors -= by_rotation * (weighted.transpose() * by_rotation)
                                .ldlt()
                                .solve(weighted.transpose() * errors);
    found += errors.squaredNorm() / kNumDraws;
  }
  for (const size_t i : seen) {
    by_white += white[i].noise_px2.trace();
    by_both += both[i].noise_px2.trace();
  }
  EXPECT_NEAR(std::sqrt(found / by_both), 1, 0.15);
  EXPECT_GT(std::sqrt(found / by_white), 1.5);
}

}  // namespace
}  // namespace raygrid
