#include "evaluation/prediction_comparison.h"

#include "support.h"

namespace raygrid {
namespace {

TEST(SignedRankProbability, IsThatOfTables) {
  EXPECT_EQ(SignedRankProbability({}), 1);
  EXPECT_EQ(SignedRankProbability({0, 0}), 1);
  // All of one sign: two of 2^n outcomes.
  EXPECT_DOUBLE_EQ(SignedRankProbability({1, 2, 3, 4, 5}), 2.0 / 32);
  EXPECT_DOUBLE_EQ(SignedRankProbability({-1, -2, -3, -4, -5}), 2.0 / 32);
  // Sums of ranks of 8 or less, of ten differences: 25 of 1024, on each side.
  EXPECT_DOUBLE_EQ(SignedRankProbability({-1, 2, 3, 4, 5, 6, -7, 8, 9, 10}),
                   50.0 / 1024);
}

TEST(SignedRankProbability, OfManyIsTheNormalOne) {
  std::vector<double> differences;
  for (int k = 1; k <= 100; ++k) differences.push_back(k % 3 == 0 ? -k : k);
  const double exact = SignedRankProbability(differences);
  differences.push_back(0.5);  // the 101st, of the smallest rank
  const double normal = SignedRankProbability(differences);
  EXPECT_GT(exact, 1e-4);
  EXPECT_LT(exact, 1e-2);
  EXPECT_NEAR(normal / exact, 1, 0.1);
}

// Errors of 0.05 px, and of a camera that is wrong by some more.
std::vector<FeatureResidual> ResidualsOfImages(int num_images, double wrong_px,
                                               unsigned seed) {
  TestRandom noise(5), random(seed);
  std::vector<FeatureResidual> residuals;
  for (int image = 0; image < num_images; ++image) {
    for (int k = 0; k < 100; ++k) {
      const Eigen::Vector2d error =
          0.05 * noise.NormalVector<2>() + wrong_px * random.NormalVector<2>();
      residuals.push_back({std::to_string(image), 0, k % 10, k / 10,
                           Eigen::Vector2d::Zero(), error});
    }
  }
  return residuals;
}

TEST(ComparePredictions, FindsTheBetterOne) {
  const auto better = ResidualsOfImages(20, 0.01, 1),
             worse = ResidualsOfImages(20, 0.03, 2);
  const PredictionComparison forth = ComparePredictions(better, worse);
  EXPECT_STREQ(forth.NameBetterCamera(), "first");
  EXPECT_LT(forth.first.rms_px, forth.second.rms_px);
  EXPECT_EQ(forth.images.size(), 20u);
  const PredictionComparison back = ComparePredictions(worse, better);
  EXPECT_STREQ(back.NameBetterCamera(), "second");
  EXPECT_EQ(back.probability, forth.probability);
}

TEST(ComparePredictions, DoesNotGuess) {
  int num_decided = 0;
  for (unsigned seed = 10; seed < 210; ++seed)
    num_decided += std::string("neither") !=
                   ComparePredictions(ResidualsOfImages(12, 0.02, seed),
                                      ResidualsOfImages(12, 0.02, seed + 1000))
                       .NameBetterCamera();
  EXPECT_LE(num_decided, 6);  // of 200, where 2 are expected
  const auto same = ResidualsOfImages(12, 0.02, 3);
  EXPECT_STREQ(ComparePredictions(same, same).NameBetterCamera(), "neither");
}

TEST(ComparePredictions, CountsOnlyWhatBothSee) {
  const auto all = ResidualsOfImages(4, 0.01, 1);
  std::vector<FeatureResidual> part(all.begin(), all.begin() + 150);
  const PredictionComparison comparison = ComparePredictions(all, part);
  EXPECT_EQ(comparison.first.count, 150);
  EXPECT_EQ(comparison.num_left_out, 250);
  EXPECT_EQ(comparison.images.size(), 2u);
  EXPECT_EQ(comparison.images[1].num_features, 50);
}

}  // namespace
}  // namespace raygrid
