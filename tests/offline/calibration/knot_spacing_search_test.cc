#include "calibration/knot_spacing_search.h"

#include "support.h"

namespace raygrid {
namespace {

using Residuals = std::vector<FeatureResidual>;

constexpr int kImages = 12, kFeaturesPerImage = 50;

// Errors of so many pixels, each image's off by an own part of the spread.
Residuals ErrorsOf(double error_px, double spread_px = 0) {
  TestRandom random(1);
  Residuals residuals;
  for (int image = 0; image < kImages; ++image) {
    const double of_image_px = error_px + spread_px * random.Normal();
    for (int i = 0; i < kFeaturesPerImage; ++i)
      residuals.push_back({"image_" + std::to_string(image),
                           0,
                           i,
                           0,
                           {0, 0},
                           {0, of_image_px}});
  }
  return residuals;
}

// The resolution that a search takes, and how many it tries.
struct Found {
  int chosen, num_tried;
};
Found Search(const std::vector<Residuals>& of_resolutions, int medium) {
  const auto search =
      KnotSpacingSearch::Run(static_cast<int>(of_resolutions.size()), medium,
                             [&](const std::vector<int>& which) {
                               std::vector<Residuals> measured;
                               for (const int i : which)
                                 measured.push_back(of_resolutions[i]);
                               return measured;
                             });
  return {search.value().chosen, static_cast<int>(search->tried.size())};
}

TEST(ComputeLossZScore, IsInDeviationsAsImagesDiffer) {
  // Losses are half squares: of 0.2 px in all images, against 0.1 px or 0.3.
  Residuals others = ErrorsOf(0.2), residuals = ErrorsOf(0.1);
  for (FeatureResidual& residual : residuals)
    if (residual.image == "image_0") residual.error_px = {0, 0.3};
  const double gain = (0.04 - 0.01) / 2, loss = (0.09 - 0.04) / 2;
  const double mean = (11 * gain - loss) / 12;
  const double variance =
      (11 * std::pow(gain - mean, 2) + std::pow(loss + mean, 2)) / 11;
  EXPECT_NEAR(ComputeLossZScore(others, residuals),
              mean / std::sqrt(variance / 12), 1e-9);
  EXPECT_NEAR(ComputeLossZScore(residuals, others),
              -mean / std::sqrt(variance / 12), 1e-9);
}

TEST(ComputeLossZScore, CountsWhatOneOfBothLacksAsAPixelOff) {
  const Residuals all = ErrorsOf(0.2);
  const Residuals some(all.begin() + 2 * kFeaturesPerImage, all.end());
  EXPECT_GT(ComputeLossZScore(some, all), 1);
  EXPECT_GT(ComputeLossZScore({}, ErrorsOf(0.2, 0.01)), 10);
}

TEST(ComputeLossZScore, NeedsTwoImages) {
  const Residuals all = ErrorsOf(0.2), less = ErrorsOf(0.1);
  const auto first = [](const Residuals& residuals) {
    return Residuals(residuals.begin(), residuals.begin() + kFeaturesPerImage);
  };
  EXPECT_EQ(ComputeLossZScore(first(all), first(less)), 0);
  EXPECT_EQ(ComputeLossZScore({}, {}), 0);
}

TEST(KnotSpacingSearch, GoesOnWhileTheLossSurelyFalls) {
  const Residuals bad = ErrorsOf(0.3, 0.01), better = ErrorsOf(0.2, 0.01),
                  best = ErrorsOf(0.1, 0.01);
  Found found = Search({bad, bad, better, best, bad, best}, 2);
  EXPECT_EQ(found.chosen, 3);
  EXPECT_EQ(found.num_tried, 4);
  found = Search({bad, best, better, bad}, 2);
  EXPECT_EQ(found.chosen, 1);
  EXPECT_EQ(found.num_tried, 3);
  found = Search({best, better, bad, best}, 2);
  EXPECT_EQ(found.chosen, 0);
  EXPECT_EQ(found.num_tried, 3);
}

TEST(KnotSpacingSearch, StaysWhereNothingIsSurelyBetter) {
  // It is better in two images, and worse in one.
  Residuals other = ErrorsOf(0.2);
  for (FeatureResidual& residual : other) {
    if (residual.image == "image_0" || residual.image == "image_1")
      residual.error_px = {0, 0.18};
    if (residual.image == "image_2") residual.error_px = {0, 0.22};
  }
  const Residuals medium = ErrorsOf(0.2);
  EXPECT_EQ(Search({other, other, medium, other, other}, 2).chosen, 2);
}

TEST(KnotSpacingSearch, TakesTheOnlyResolution) {
  const Found found = Search({ErrorsOf(0.1)}, 2);
  EXPECT_EQ(found.chosen, 0);
  EXPECT_EQ(found.num_tried, 1);
}

TEST(KnotSpacingSearch, DoesNotMeasureWhatLosesInAProbe) {
  const std::vector<Residuals> of_resolutions = {
      ErrorsOf(0.3, 0.01), ErrorsOf(0.3, 0.01),  ErrorsOf(0.2, 0.01),
      ErrorsOf(0.1, 0.01), ErrorsOf(0.15, 0.01), ErrorsOf(0.05, 0.01)};
  std::vector<int> probed;
  const auto search = KnotSpacingSearch::Run(
      6, 2,
      [&](const std::vector<int>& which) {
        std::vector<Residuals> measured;
        for (const int i : which) measured.push_back(of_resolutions[i]);
        return measured;
      },
      [&](int i) {
        probed.push_back(i);
        const Residuals& all = of_resolutions[i];
        return Residuals(all.begin(), all.begin() + 4 * kFeaturesPerImage);
      });
  EXPECT_EQ(search.value().chosen, 3);
  EXPECT_EQ(probed, (std::vector<int>{3, 4}));
  EXPECT_EQ(search->tried.count(3), 1u);
  EXPECT_EQ(search->tried.count(4), 0u);
}

TEST(KnotSpacingSearch, EndsWithAStop) {
  int calls = 0;
  const auto search =
      KnotSpacingSearch::Run(4, 2, [&](const std::vector<int>& which) {
        std::vector<Residuals> measured;
        if (++calls == 1) measured.assign(which.size(), ErrorsOf(0.1));
        return measured;
      });
  EXPECT_FALSE(search.has_value());
  EXPECT_EQ(calls, 2);
}

}  // namespace
}  // namespace raygrid
