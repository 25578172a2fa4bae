#include "evaluation/residual_statistics.h"

#include "support.h"

namespace raygrid {
namespace {

const Area kArea = {0, 0, 640, 480};

FeatureResidual At(const Eigen::Vector2d& pixel, const Eigen::Vector2d& error) {
  return {"a.png", 0, 0, 0, pixel, error};
}

// Many residuals in each of some places, around a mean that depends on place.
template <typename Function>
std::vector<FeatureResidual> Residuals(int per_place, const Function& mean_of) {
  TestRandom random(1);
  std::vector<FeatureResidual> residuals;
  for (int place = 0; place < 20; ++place) {
    const Eigen::Vector2d pixel(30 * place + 20, 20 * place + 20);
    for (int i = 0; i < per_place; ++i)
      residuals.push_back(
          At(pixel, 0.1 * (random.NormalVector<2>() + mean_of(place))));
  }
  return residuals;
}

Eigen::Vector2d Nowhere(int) { return Eigen::Vector2d::Zero(); }

TEST(Quantile, InterpolatesBetweenOrderStatistics) {
  EXPECT_EQ(Quantile({3, 1, 2}, 0.5), 2);
  EXPECT_EQ(Quantile({3, 1, 2}, 0), 1);
  EXPECT_EQ(Quantile({3, 1, 2}, 1), 3);
  EXPECT_DOUBLE_EQ(Quantile({3, 1, 2}, 0.25), 1.5);
  EXPECT_DOUBLE_EQ(Quantile({4, 1, 2, 3}, 0.5), 2.5);
  EXPECT_EQ(Quantile({7}, 0.3), 7);
  EXPECT_EQ(Quantile({}, 0.5), 0);
}

TEST(ErrorFigures, AreThoseOfTheNorms) {
  const ErrorFigures figures = ComputeErrorFigures(
      {At({0, 0}, {3, 4}), At({0, 0}, {0, 1}), At({0, 0}, {-2, 0})});
  EXPECT_DOUBLE_EQ(figures.median_px, 2);
  EXPECT_DOUBLE_EQ(figures.rms_px, std::sqrt(30 / 3.0));
  EXPECT_DOUBLE_EQ(figures.max_px, 5);
  EXPECT_EQ(figures.count, 3);
}

TEST(ErrorFigures, OfNothingAreZero) {
  const ErrorFigures figures = ComputeErrorFigures({});
  EXPECT_EQ(figures.count, 0);
  EXPECT_EQ(figures.max_px, 0);
}

TEST(Bias, IsNearZeroForPureNoise) {
  EXPECT_LT(ComputeBias(Residuals(2000, Nowhere), kArea).value(), 0.05);
}

TEST(Bias, DoesNotDependOnTheNoisesStrength) {
  std::vector<FeatureResidual> residuals = Residuals(500, Nowhere);
  const double bias = ComputeBias(residuals, kArea).value();
  for (FeatureResidual& residual : residuals) residual.error_px *= 7;
  EXPECT_NEAR(ComputeBias(residuals, kArea).value(), bias, 1e-9);
}

TEST(Bias, IsLargeWhereNeighboursErrAlike) {
  const auto systematic = [](int place) {
    return Eigen::Vector2d(2 * std::cos(place), 2 * std::sin(place));
  };
  EXPECT_GT(ComputeBias(Residuals(2000, systematic), kArea).value(), 0.5);
}

TEST(Bias, NeedsFiveResidualsInAPlace) {
  EXPECT_FALSE(ComputeBias(Residuals(4, Nowhere), kArea));
  EXPECT_TRUE(ComputeBias(Residuals(5, Nowhere), kArea));
  EXPECT_FALSE(ComputeBias({}, kArea));
}

}  // namespace
}  // namespace raygrid
