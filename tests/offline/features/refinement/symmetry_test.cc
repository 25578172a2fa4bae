#include <cmath>

#include "features/refinement/float_lanes.h"
#include "features/refinement/symmetry_patch.h"
#include "features/refinement/symmetry_refinement.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr ImageSize kPatchSize = {60, 50};

GreyImage SimulateImageFeatures(
    const std::function<double(double x, double y)>& level) {
  GreyImage image;
  image.size = kPatchSize;
  for (int y = 0; y < kPatchSize.height; ++y)
    for (int x = 0; x < kPatchSize.width; ++x)
      image.levels.push_back(static_cast<float>(level(x, y)));
  for (const float l : image.levels)
    image.bytes.push_back(static_cast<uint8_t>(std::lround(l)));
  return image;
}

TEST(FloatLanes, InterpolateAsOneFloatDoes) {
  TestRandom random(1);
  constexpr int kWidth = 9, kHeight = 7;
  std::vector<float> values;
  for (int i = 0; i < kWidth * kHeight; ++i)
    values.push_back(static_cast<float>(random.Uniform(0, 255)));
  for (int trial = 0; trial < 100; ++trial) {
    FloatLanes x, y;
    for (int k = 0; k < kLanes; ++k) {
      x[k] = static_cast<float>(random.Uniform(0, kWidth - 1.001));
      y[k] = static_cast<float>(random.Uniform(0, kHeight - 2.001));
    }
    // From the second row on.
    const SampledLanes s = Bilinear(values.data(), kWidth, kWidth, x, y);
    for (int k = 0; k < kLanes; ++k) {
      const int ix = static_cast<int>(x[k]), iy = static_cast<int>(y[k]);
      const double fx = x[k] - ix, fy = y[k] - iy;
      const auto at = [&](int i, int j) {
        return double{values[(iy + j + 1) * kWidth + ix + i]};
      };
      EXPECT_NEAR(s.value[k],
                  (1 - fy) * ((1 - fx) * at(0, 0) + fx * at(1, 0)) +
                      fy * ((1 - fx) * at(0, 1) + fx * at(1, 1)),
                  1e-3);
      EXPECT_NEAR(s.dx[k],
                  (1 - fy) * (at(1, 0) - at(0, 0)) + fy * (at(1, 1) - at(0, 1)),
                  1e-3);
      EXPECT_NEAR(s.dy[k],
                  (1 - fx) * (at(0, 1) - at(0, 0)) + fx * (at(1, 1) - at(1, 0)),
                  1e-3);
    }
  }
}

TEST(SymmetryPatch, EnlargesWavesFourPixelsLong) {
  const auto wave = [](double x, double y) {
    return 128 + 60 * std::sin(M_PI / 2 * x + 0.3) + 40 * std::cos(0.9 * y);
  };
  constexpr int kReach = 12;
  const Eigen::Vector2i center(30, 25);
  const SymmetryPatch patch(SimulateImageFeatures(wave),
                            Refinement::kIntensities, center, kReach);
  ASSERT_EQ(patch.channels().size(), 1u);
  EXPECT_EQ(patch.side(), 50);
  EXPECT_EQ(patch.FromPixel({30, 25}), Eigen::Vector2d(24, 24));
  double largest = 0;
  for (int y = 0; y < patch.side(); ++y)
    for (int x = 0; x < patch.side(); ++x)
      largest = std::max(
          largest,
          std::fabs(patch.channels()[0][y * patch.side() + x] -
                    wave(30 - kReach + x / 2.0, 25 - kReach + y / 2.0)));
  // Linear interpolation would err by 18 and 4.
  EXPECT_LT(largest, 0.8);
}

TEST(SymmetryPatch, RepeatsTheImagesEdge) {
  const GreyImage image =
      SimulateImageFeatures([](double x, double) { return 4 * x; });
  const SymmetryPatch patch(image, Refinement::kIntensities, {1, 48}, 8);
  const std::vector<float>& levels = patch.channels()[0];
  EXPECT_NEAR(levels[0], 0, 1e-4);
  const int last = patch.side() - 2;
  EXPECT_NEAR(levels[last * patch.side() + last], 4 * 9, 1e-3);
}

TEST(SymmetryPatch, HasAsManyChannelsAsTheRefinementWants) {
  const GreyImage image =
      SimulateImageFeatures([](double x, double y) { return x + 2 * y; });
  const SymmetryPatch xy(image, Refinement::kGradientsXY, {30, 25}, 8);
  ASSERT_EQ(xy.channels().size(), 2u);
  const int middle = 17 * xy.side() + 17;
  EXPECT_NEAR(xy.channels()[0][middle], 1, 1e-4);  // over two half pixels
  EXPECT_NEAR(xy.channels()[1][middle], 2, 1e-4);
  const SymmetryPatch size(image, Refinement::kGradientMagnitude, {30, 25}, 8);
  ASSERT_EQ(size.channels().size(), 1u);
  EXPECT_NEAR(size.channels()[0][middle], std::sqrt(5), 1e-4);
}

// Symmetric everywhere.
SymmetryMask WholeMask() {
  const Pattern pattern = ChessboardPattern(9, 9, 0.02);
  return SymmetryMask::MakeBoardMasks(pattern.boards[0])[4 * 9 + 4];
}

LocalMapping TiltedMapping() {
  LocalMapping mapping;
  mapping.center = {30.37, 24.81};
  mapping.linear << 22, 3, -4, 19;
  mapping.perspective = {0.05, -0.03};
  return mapping;
}

// A smooth pattern of the board: even, or odd about its middle.
double Even(const Eigen::Vector2d& s) {
  return std::cos(2 * M_PI * s.x()) * std::cos(2.6 * s.y()) +
         0.5 * std::cos(3 * s.x() + 5 * s.y());
}
double Odd(const Eigen::Vector2d& s) {
  return std::sin(5 * s.x() + 2 * s.y()) + 0.6 * std::sin(6 * s.y());
}

// Seen through the mapping, by Newton's method backwards.
GreyImage SeenThrough(const LocalMapping& mapping,
                      double (*pattern)(const Eigen::Vector2d&)) {
  return SimulateImageFeatures([&](double x, double y) {
    const Eigen::Vector2d pixel(x, y);
    Eigen::Vector2d s = Eigen::Vector2d::Zero();
    for (int i = 0; i < 20; ++i)
      s += mapping.linear.inverse() * (pixel - mapping(s));
    return 128 + 60 * pattern(s);
  });
}

double ErrorPx(const LocalMapping& truth,
               double (*pattern)(const Eigen::Vector2d&),
               const LocalMapping& start, const SymmetryOptions& options) {
  const WindowFit result =
      RefineSymmetry(SeenThrough(truth, pattern), MakeSymmetrySamples(21, 8),
                     WholeMask(), start, options);
  EXPECT_TRUE(result.is_converged);
  return (result.mapping.center - truth.center).norm();
}

LocalMapping Displaced(LocalMapping mapping) {
  mapping.center += Eigen::Vector2d(0.6, -0.4);
  return mapping;
}

TEST(RefineSymmetry, FindsTheCentre) {
  const LocalMapping truth = TiltedMapping();
  SymmetryOptions options;
  options.center_only = true;
  EXPECT_LT(ErrorPx(truth, Even, Displaced(truth), options), 0.003);
}

// Perspective scales gradients, and so they are symmetric only without.
TEST(RefineSymmetry, FindsTheCentreOfGradients) {
  LocalMapping truth = TiltedMapping();
  truth.perspective.setZero();
  for (const Refinement refinement :
       {Refinement::kGradientsXY, Refinement::kGradientMagnitude}) {
    SymmetryOptions options;
    options.refinement = refinement;
    options.center_only = true;
    EXPECT_LT(ErrorPx(truth, Even, Displaced(truth), options), 0.003);
  }
}

TEST(RefineSymmetry, FindsTheCentreOfColoursInverted) {
  const LocalMapping truth = TiltedMapping();
  SymmetryOptions options;
  options.inverts_colors = true;
  options.center_only = true;
  EXPECT_LT(ErrorPx(truth, Odd, Displaced(truth), options), 0.003);
}

TEST(RefineSymmetry, FindsThePerspectiveToo) {
  const LocalMapping truth = TiltedMapping();
  LocalMapping start = Displaced(truth);
  start.perspective.setZero();
  SymmetryOptions options;
  EXPECT_LT(ErrorPx(truth, Even, start, options), 0.005);
  options.center_only = true;  // and without it, errs
  EXPECT_GT(ErrorPx(truth, Even, start, options), 0.02);
}

TEST(RefineSymmetry, NeedsTheCurvature) {
  LocalMapping truth = TiltedMapping();
  truth.perspective.setZero();
  truth.curvature.leftCols<3>() << 0.5, -0.2, 0.3, 0.1, 0.4, -0.5;
  SymmetryOptions options;
  options.center_only = true;
  EXPECT_LT(ErrorPx(truth, Even, Displaced(truth), options), 0.003);
  LocalMapping straight = Displaced(truth);
  straight.curvature.setZero();
  EXPECT_GT(ErrorPx(truth, Even, straight, options), 0.02);
}

TEST(RefineSymmetry, RefusesWhatIsFarOrBesideTheImage) {
  LocalMapping start = TiltedMapping();
  const GreyImage image = SeenThrough(start, Even);
  const SymmetrySamples samples = MakeSymmetrySamples(21, 8);
  SymmetryOptions options;
  options.center_only = true;
  options.max_move_px = 0.1;
  EXPECT_FALSE(
      RefineSymmetry(image, samples, WholeMask(), Displaced(start), options)
          .is_converged);
  options.max_move_px = 2;
  for (const double x : {-500.0, 1.0, 59.0, 1e9, double{NAN}}) {
    start.center.x() = x;
    EXPECT_FALSE(RefineSymmetry(image, samples, WholeMask(), start, options)
                     .is_converged)
        << x;
  }
}

}  // namespace
}  // namespace raygrid
