#include "adjustment/covariance.h"

#include "small_problem.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr double kObservedNoisePx = 0.2;
const UncertaintyOptions kLattice = {9, 7};
constexpr int kAllExact = 100000;

UncertaintyOptions Sampled(int num_samples) {
  UncertaintyOptions options = kLattice;
  options.num_samples = num_samples;
  return options;
}

// By white noise.
std::vector<PixelUncertainty> UncertaintyFor(
    const SmallProblem& problem, const GaussianPrior& prior,
    const AdjustmentOptions& options, double noise_px,
    const UncertaintyOptions& lattice = kLattice,
    int max_exact_unknowns = kAllExact) {
  const LinearResponse response(problem.views, prior, options, problem.state,
                                max_exact_unknowns);
  return EstimateProjectionUncertainty(
      response, noise_px, nullptr, problem.views, problem.state, 0, lattice);
}

SmallProblem ExactProblem() { return MakeExactGridProblem(25, 60); }

// Pixel errors of the places where the lattice's true rays are seen, less the
// rotation that brings observations nearest to where they truly are.
Eigen::VectorXd Errors(const CameraModel& camera, const CameraModel& truth,
                       const std::vector<PixelUncertainty>& pixels) {
  const Eigen::Index size = 2 * static_cast<Eigen::Index>(pixels.size());
  Eigen::VectorXd errors(size);
  Eigen::MatrixX3d J_rotation(size, 3), supported(size, 3);
  for (size_t i = 0; i < pixels.size(); ++i) {
    const Eigen::Index row = 2 * static_cast<Eigen::Index>(i);
    const Eigen::Vector2d& pixel = pixels[i].pixel;
    const Eigen::Vector3d ray = truth.Unproject(pixel).value();
    errors.segment<2>(row) =
        camera.Project(ray, &pixel, 50).value_or(pixel) - pixel;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d turn = 1e-5 * Eigen::Vector3d::Unit(k);
      J_rotation.block<2, 1>(row, k) =
          (truth.Project(RotationFromVector(turn) * ray, &pixel, 50).value() -
           pixel) /
          1e-5;
    }
    supported.middleRows<2>(row) =
        pixels[i].num_observations * J_rotation.middleRows<2>(row);
  }
  return errors - J_rotation * (supported.transpose() * J_rotation)
                                   .ldlt()
                                   .solve(supported.transpose() * errors);
}

TEST(EstimateProjectionUncertainty, IsHowAdjustedCamerasScatterWithTheNoise) {
  constexpr int kNumDraws = 50;
  const SmallProblem exact = ExactProblem();
  const GaussianPrior prior = WeakPrior(exact);
  Eigen::MatrixXd joint_px2;
  const LinearResponse response(exact.views, prior, FixedPoints(), exact.state);
  const std::vector<PixelUncertainty> predicted = EstimateProjectionUncertainty(
      response, kObservedNoisePx, nullptr, exact.views, exact.state, 0,
      kLattice, &joint_px2);
  ASSERT_EQ(predicted.size(), 63u);
  ASSERT_EQ(joint_px2.rows(), 126);
  for (size_t i = 0; i < predicted.size(); ++i)
    EXPECT_LT(RelativeDifference((joint_px2.block<2, 2>(2 * i, 2 * i)),
                                 predicted[i].total_px2),
              1e-6);
  TestRandom random(77);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(126);
  for (int draw = 0; draw < kNumDraws; ++draw) {
    std::vector<View> views = exact.views;
    for (View& view : views)
      for (Observation& o : view.observations)
        o.pixel += kObservedNoisePx * random.NormalVector<2>();
    AdjustmentState state = exact.state;
    RunBundleAdjustment(views, prior, FixedPoints(), &state);
    sum += Errors(state.camera(), exact.state.camera(), predicted).cwiseAbs2();
  }
  // Over the lattice, and about each pixel, as well as 50 draws can tell.
  double predicted_sum = 0;
  int num_within = 0, num_seen = 0;
  for (size_t i = 0; i < predicted.size(); ++i) {
    if (predicted[i].num_observations < 3) continue;
    ++num_seen;
    const double expected = predicted[i].noise_px2.trace();
    const double found = sum.segment<2>(2 * i).sum() / kNumDraws;
    predicted_sum += std::log(found / expected) / 2;
    num_within += std::abs(std::sqrt(found / expected) - 1) < 0.2;
  }
  ASSERT_GT(num_seen, 10);
  EXPECT_NEAR(std::exp(predicted_sum / num_seen), 1, 0.1);
  EXPECT_GE(num_within, 0.9 * num_seen);
}

TEST(EstimateProjectionUncertainty, SamplesAgreeWithTheFactor) {
  const SmallProblem exact = ExactProblem();
  const GaussianPrior prior = WeakPrior(exact);
  // Deviations are known to 3 % from so many. Few directions, in which little
  // is known, make up most of all pixels' deviations: their mean is known no
  // better than one.
  const UncertaintyOptions sampled = Sampled(512);
  for (const bool fix_points : {true, false}) {
    AdjustmentOptions options = FixedPoints();
    options.fix_points = fix_points;
    const auto expected =
        UncertaintyFor(exact, prior, options, kObservedNoisePx);
    const auto found =
        UncertaintyFor(exact, prior, options, kObservedNoisePx, sampled, 0);
    ASSERT_EQ(found.size(), expected.size());
    double noise_sum = 0, total_sum = 0;
    for (size_t i = 0; i < found.size(); ++i) {
      const auto ratio = [&](Eigen::Matrix2d PixelUncertainty::*member) {
        return ComputeAxisStdDev(found[i].*member) /
               ComputeAxisStdDev(expected[i].*member);
      };
      const double noise = ratio(&PixelUncertainty::noise_px2);
      const double total = ratio(&PixelUncertainty::total_px2);
      EXPECT_NEAR(noise, 1, 0.2);
      EXPECT_NEAR(total, 1, 0.2);
      noise_sum += noise;
      total_sum += total;
    }
    const auto count = static_cast<double>(found.size());
    EXPECT_NEAR(noise_sum / count, 1, 0.1);
    EXPECT_NEAR(total_sum / count, 1, 0.1);
  }
}

TEST(EstimateProjectionUncertainty, SamplesAreTheSameWithAnyNumberOfThreads) {
  const SmallProblem exact = ExactProblem();
  AdjustmentOptions options = FixedPoints();
  std::vector<PixelUncertainty> first;
  for (const int num_threads : {1, 3}) {
    options.num_threads = num_threads;
    const auto found = UncertaintyFor(exact, WeakPrior(exact), options,
                                      kObservedNoisePx, Sampled(3), 0);
    ASSERT_FALSE(found.empty());
    if (first.empty()) first = found;
    for (size_t i = 0; i < found.size(); ++i)
      EXPECT_EQ(found[i].total_px2, first[i].total_px2);
  }
}

TEST(EstimateProjectionUncertainty, GrowsWithTheNoiseAndWhereFewFeaturesAre) {
  const SmallProblem exact = ExactProblem();
  const GaussianPrior prior = WeakPrior(exact);
  const auto once = UncertaintyFor(exact, prior, FixedPoints(), 0.1);
  const auto twice = UncertaintyFor(exact, prior, FixedPoints(), 0.2);
  const PixelUncertainty& corner = once.front();
  const PixelUncertainty& middle = once[once.size() / 2];
  EXPECT_NEAR(ComputeAxisStdDev(twice.front().total_px2),
              2 * ComputeAxisStdDev(corner.total_px2), 1e-9);
  EXPECT_LT(ComputeAxisStdDev(middle.total_px2),
            ComputeAxisStdDev(corner.total_px2));
  EXPECT_GT(middle.num_observations, corner.num_observations);
}

}  // namespace
}  // namespace raygrid
