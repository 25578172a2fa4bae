#include "evaluation/residual_statistics.h"

#include "support.h"

namespace raygrid {
namespace {

const Area kImageArea = {0, 0, 640, 480};

FeatureResidual At(const Eigen::Vector2d& pixel, const Eigen::Vector2d& error) {
  return {"a.png", 0, 0, 0, pixel, error};
}

// Many residuals in each of some places, around a mean that depends on place.
template <typename Function>
std::vector<FeatureResidual> ResidualsInPlaces(int per_place,
                                               const Function& mean_of) {
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

TEST(ErrorMetrics, AreThoseOfTheNorms) {
  const ErrorMetrics metrics = ComputeErrorMetrics(
      {At({0, 0}, {3, 4}), At({0, 0}, {0, 1}), At({0, 0}, {-2, 0})});
  EXPECT_DOUBLE_EQ(metrics.median_px, 2);
  EXPECT_DOUBLE_EQ(metrics.rms_px, std::sqrt(30 / 3.0));
  EXPECT_DOUBLE_EQ(metrics.max_px, 5);
  EXPECT_EQ(metrics.count, 3);
}

TEST(ErrorMetrics, OfNothingAreZero) {
  const ErrorMetrics metrics = ComputeErrorMetrics({});
  EXPECT_EQ(metrics.count, 0);
  EXPECT_EQ(metrics.max_px, 0);
}

TEST(Bias, IsNearZeroForPureNoise) {
  EXPECT_LT(ComputeBias(ResidualsInPlaces(2000, Nowhere), kImageArea).value(),
            0.05);
}

TEST(Bias, DoesNotDependOnTheNoisesStrength) {
  std::vector<FeatureResidual> residuals = ResidualsInPlaces(500, Nowhere);
  const double bias = ComputeBias(residuals, kImageArea).value();
  for (FeatureResidual& residual : residuals) residual.error_px *= 7;
  EXPECT_NEAR(ComputeBias(residuals, kImageArea).value(), bias, 1e-9);
}

TEST(Bias, IsLargeWhereNeighboursErrAlike) {
  const auto systematic = [](int place) {
    return Eigen::Vector2d(2 * std::cos(place), 2 * std::sin(place));
  };
  EXPECT_GT(
      ComputeBias(ResidualsInPlaces(2000, systematic), kImageArea).value(),
      0.5);
}

TEST(Bias, NeedsFiveResidualsInAPlace) {
  EXPECT_FALSE(ComputeBias(ResidualsInPlaces(4, Nowhere), kImageArea));
  EXPECT_TRUE(ComputeBias(ResidualsInPlaces(5, Nowhere), kImageArea));
  EXPECT_FALSE(ComputeBias({}, kImageArea));
}

// A board of 20 x 15 features in each of two images; error_at(column, row).
template <typename Function>
std::vector<FeatureResidual> BoardResiduals(const Function& error_at) {
  std::vector<FeatureResidual> residuals;
  for (const char* image : {"a.png", "b.png"})
    for (int row = 0; row < 15; ++row)
      for (int column = 0; column < 20; ++column)
        residuals.push_back(
            {image, 0, column, row, {0, 0}, error_at(column, row)});
  return residuals;
}

TEST(ComputeNeighborCorrelation, OfNoiseIsNone) {
  TestRandom random(3);
  const auto noise = [&](int, int) { return random.NormalVector<2>(); };
  EXPECT_NEAR(ComputeNeighborCorrelation(BoardResiduals(noise)).value(), 0,
              0.1);
}

TEST(ComputeNeighborCorrelation, IsThePartOfTheSquaresThatIsSmooth) {
  TestRandom random(4);
  const auto half = [&](int column, int row) -> Eigen::Vector2d {
    const double phase = 0.1 * column + 0.2 * row;
    return M_SQRT2 * Eigen::Vector2d(std::sin(phase), std::cos(phase)) +
           random.NormalVector<2>();
  };
  EXPECT_NEAR(ComputeNeighborCorrelation(BoardResiduals(half)).value(), 0.5,
              0.1);
  const auto smooth = [](int column, int) {
    return Eigen::Vector2d(0.1 * column, 1);
  };
  EXPECT_GT(ComputeNeighborCorrelation(BoardResiduals(smooth)).value(), 0.95);
}

TEST(ComputeNeighborCorrelation, NeighboursAreOnOneBoardInOneImage) {
  std::vector<FeatureResidual> residuals =
      BoardResiduals([](int, int) { return Eigen::Vector2d(1, 1); });
  for (size_t i = 0; i < residuals.size(); ++i)
    residuals[i].board = static_cast<int>(i);
  EXPECT_FALSE(ComputeNeighborCorrelation(residuals));
  EXPECT_FALSE(ComputeNeighborCorrelation({}));
}

TEST(ComputeSystematicError, IsWhatRepeatsInAllImages) {
  const Area area{0, 0, 640, 480};
  const auto residuals = [&](int num_images, double systematic_px) {
    TestRandom random(5);
    std::vector<FeatureResidual> all;
    for (int image = 0; image < num_images; ++image) {
      const Eigen::Vector2d of_image = 0.5 * random.NormalVector<2>();
      for (int k = 0; k < 100; ++k) {
        const Eigen::Vector2d pixel(64 * (k % 10) + 30, 48 * (k / 10) + 20);
        const double phase = 0.01 * pixel.x();
        all.push_back(
            {std::to_string(image), 0, 0, k, pixel,
             systematic_px * Eigen::Vector2d(std::sin(phase), std::cos(phase)) +
                 of_image + random.NormalVector<2>()});
      }
    }
    return all;
  };
  // The part of an image does not repeat: 0.5 sqrt(2) px of it and of noise.
  EXPECT_NEAR(ComputeSystematicError(residuals(40, 1), area).value(), 1, 0.15);
  EXPECT_LT(ComputeSystematicError(residuals(40, 0), area).value(), 0.3);
  EXPECT_FALSE(ComputeSystematicError(residuals(4, 1), area));
  EXPECT_FALSE(ComputeSystematicError({}, area));
}

}  // namespace
}  // namespace raygrid
