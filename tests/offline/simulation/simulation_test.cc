#include "simulation/simulated_camera.h"
#include "simulation/simulated_observations.h"
#include "support.h"

namespace raygrid {
namespace {

SimulationOptions FewImages() {
  SimulationOptions options;
  options.num_images = 20;
  options.features_per_image = 120;
  return options;
}

SimulatedObservations Simulate(const SimulationOptions& options) {
  return SimulateObservations(ExampleSimulatedCamera(),
                              ChessboardPattern(18, 12, 0.03), options);
}

TEST(SimulatedCamera, ProjectionInvertsUnprojection) {
  ExpectRoundTrip(ExampleSimulatedCamera(), 1e-6);
}

TEST(SimulatedCamera, DerivativeByPointIsThatOfProjection) {
  ExpectDerivativeByPoint(ExampleSimulatedCamera(), 1e-6);
}

TEST(SimulatedCamera, BumpMovesThePixelsAroundIt) {
  const Eigen::Vector2d center(300, 200), shift(1.5, -0.5);
  const SimulatedCamera bumped(ExampleLens(), {{center, shift, 60}});
  const Eigen::Vector3d ray = *ExampleLens().Unproject(center);
  EXPECT_LT((*bumped.Project(ray) - center - shift).norm(), 1e-6);
  const Eigen::Vector2d far(20, 460);
  EXPECT_LT((*bumped.Project(*ExampleLens().Unproject(far)) - far).norm(),
            1e-4);
}

TEST(SimulateObservations, SameSeedGivesTheSameObservations) {
  EXPECT_EQ(FormatFeatures(Simulate(FewImages()).dataset),
            FormatFeatures(Simulate(FewImages()).dataset));
}

TEST(SimulateObservations, OtherSeedGivesOtherObservations) {
  SimulationOptions other = FewImages();
  other.seed = 2;
  EXPECT_NE(FormatFeatures(Simulate(FewImages()).dataset),
            FormatFeatures(Simulate(other).dataset));
}

TEST(SimulateObservations, MakesAsManyImagesAndFeaturesAsAsked) {
  const Dataset dataset = Simulate(FewImages()).dataset;
  ASSERT_EQ(dataset.images.size(), 20u);
  for (const ImageFeatures& image : dataset.images)
    EXPECT_EQ(image.features.size(), 120u);
}

// Calls use(exact, observed) for each feature.
template <typename Function>
void ForEachFeature(const SimulatedObservations& simulated,
                    const Function& use) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const Board& board = simulated.true_pattern.boards[0];
  for (size_t i = 0; i < simulated.dataset.images.size(); ++i)
    for (const Feature& feature : simulated.dataset.images[i].features)
      use(camera
              .Project(
                  simulated.poses[i].camera_from_board *
                  board.points[board.PointIndex(feature.column, feature.row)])
              .value(),
          feature.pixel);
}

TEST(SimulateObservations, NoiseHasTheStandardDeviationAskedFor) {
  SimulationOptions options = FewImages();
  options.noise_px = 0.2;
  double sum[2] = {0, 0}, squares[2] = {0, 0};
  int count = 0;
  ForEachFeature(Simulate(options), [&](const Eigen::Vector2d& exact,
                                        const Eigen::Vector2d& observed) {
    for (int k = 0; k < 2; ++k) {
      sum[k] += observed[k] - exact[k];
      squares[k] += std::pow(observed[k] - exact[k], 2);
    }
    ++count;
  });
  ASSERT_EQ(count, 2400);
  for (int k = 0; k < 2; ++k) {
    EXPECT_NEAR(sum[k] / count, 0, 0.015);
    EXPECT_NEAR(std::sqrt(squares[k] / count), 0.2, 0.01);
  }
}

TEST(SimulateObservations, WithoutNoiseTheyAreExactAndInsideTheImage) {
  SimulationOptions options = FewImages();
  options.noise_px = 0;
  options.board_bend_m = 0.004;
  const Area image = WholeImage({640, 480});
  ForEachFeature(Simulate(options), [&](const Eigen::Vector2d& exact,
                                        const Eigen::Vector2d& observed) {
    EXPECT_LT((exact - observed).norm(), 1e-9);
    EXPECT_TRUE(image.Contains(observed));
  });
}

TEST(SimulateObservations, NoisyFeaturesStayInsideTheImage) {
  SimulationOptions options = FewImages();
  options.noise_px = 0.3;
  const SimulatedObservations simulated = Simulate(options);
  EXPECT_NO_THROW(RequireConsistent("simulated", simulated.dataset,
                                    simulated.true_pattern));
}

TEST(SimulateObservations, BendLiftsTheBoardsEdges) {
  SimulationOptions options = FewImages();
  options.board_bend_m = 0.003;
  const SimulatedObservations simulated = Simulate(options);
  double largest = 0;
  for (const Eigen::Vector3d& p : simulated.true_pattern.boards[0].points)
    largest = std::max(largest, p.z());
  EXPECT_NEAR(largest, 0.0045, 1e-9);  // in the corners: 1 + 1/2 of it
}

TEST(SimulateObservations, FeaturesReachAllQuartersOfTheImage) {
  int counts[4] = {0, 0, 0, 0};
  const SimulatedObservations simulated = Simulate(FewImages());
  for (const ImageFeatures& image : simulated.dataset.images)
    for (const Feature& f : image.features)
      ++counts[(f.pixel.x() > 320) + 2 * (f.pixel.y() > 240)];
  for (const int count : counts) EXPECT_GT(count, 200);
}

}  // namespace
}  // namespace raygrid
