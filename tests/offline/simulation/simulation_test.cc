#include <map>

#include "simulation/board_deformation.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_observations.h"
#include "simulation/simulated_rig.h"
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

// Calls use(exact, observed) for each feature whose exact place is in the area.
template <typename Function>
void ForEachFeature(const SimulatedObservations& simulated,
                    const Function& use) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const Board& board = simulated.true_pattern.boards[0];
  for (size_t i = 0; i < simulated.dataset.images.size(); ++i)
    for (const Feature& feature : simulated.dataset.images[i].features)
      if (const auto exact = camera.Project(
              simulated.poses[i].camera_from_board *
              board.points[board.PointIndex(feature.column, feature.row)]))
        use(*exact, feature.pixel);
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

TEST(SimulateObservations, SharedNoiseIsAlikeBetweenNeighboursInAnImage) {
  SimulationOptions options = FewImages();
  options.noise_px = 0;
  options.shared_noise_px = 0.2;
  options.shared_noise_features = 8;
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const SimulatedObservations simulated = Simulate(options);
  const Board& board = simulated.true_pattern.boards[0];
  double square = 0, near = 0;
  int count = 0, num_near = 0;
  for (size_t i = 0; i < simulated.dataset.images.size(); ++i) {
    std::map<std::pair<int, int>, Eigen::Vector2d> errors;
    for (const Feature& f : simulated.dataset.images[i].features)
      errors[{f.column, f.row}] =
          f.pixel -
          camera
              .Project(simulated.poses[i].camera_from_board *
                       board.points[board.PointIndex(f.column, f.row)])
              .value();
    for (const auto& [place, error] : errors) {
      square += error.squaredNorm();
      ++count;
      const auto next = errors.find({place.first + 1, place.second});
      if (next == errors.end()) continue;
      near += error.dot(next->second);
      ++num_near;
    }
  }
  // Few independent fields: an image is hardly wider than one.
  const double variance = square / (2 * count);
  EXPECT_NEAR(std::sqrt(variance), 0.2, 0.05);
  EXPECT_NEAR(near / (2 * num_near) / variance, std::exp(-1.0 / 128), 0.05);
}

TEST(SimulateObservations, WithoutNoiseTheyAreExactAndInsideTheImage) {
  SimulationOptions options = FewImages();
  options.noise_px = 0;
  options.board_sagitta_m = 0.004;
  const Area image = WholeImage({640, 480});
  int count = 0;
  ForEachFeature(Simulate(options), [&](const Eigen::Vector2d& exact,
                                        const Eigen::Vector2d& observed) {
    EXPECT_LT((exact - observed).norm(), 1e-9);
    EXPECT_TRUE(image.Contains(observed));
    ++count;
  });
  EXPECT_EQ(count, 2400);
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
  options.board_sagitta_m = 0.003;
  const SimulatedObservations simulated = Simulate(options);
  double largest = 0;
  for (const Eigen::Vector3d& p : simulated.true_pattern.boards[0].points)
    largest = std::max(largest, p.z());
  EXPECT_NEAR(largest, 0.0045, 1e-9);  // in the corners: 1 + 1/2 of it
}

TEST(DeformBoard, HasTheDeviationAskedForAndIsNoPose) {
  const Board board = ChessboardPattern(18, 12, 0.03).boards[0];
  const double count = static_cast<double>(board.points.size());
  Random random(1);
  double squares = 0, moved = 0;
  constexpr int kBoards = 400;
  for (int i = 0; i < kBoards; ++i) {
    const Board flexed = DeformBoard(board, 1e-4, &random);
    Eigen::Vector3d plane = Eigen::Vector3d::Zero();  // height and tilts
    for (size_t k = 0; k < board.points.size(); ++k) {
      const Eigen::Vector3d away = flexed.points[k] - board.points[k];
      EXPECT_EQ(away.head<2>().norm(), 0);
      squares += away.z() * away.z() / count / kBoards;
      const Eigen::Vector2d from_center =
          board.points[k].head<2>() - board.points.back().head<2>() / 2;
      plane +=
          away.z() / count *
          Eigen::Vector3d(1, from_center.x() / 0.15, from_center.y() / 0.1);
    }
    moved += plane.squaredNorm() / kBoards;
  }
  EXPECT_NEAR(std::sqrt(squares), 1.1e-4, 0.1e-4);
  EXPECT_LT(std::sqrt(moved), 0.35e-4);
}

TEST(SimulateObservations, EachViewBendsTheBoardInItsOwnWay) {
  SimulationOptions options = FewImages();
  options.noise_px = 0;
  options.board_deformation_m = 0.001;
  const SimulatedObservations simulated = Simulate(options);
  double sum = 0;
  ForEachFeature(simulated, [&](const Eigen::Vector2d& exact,
                                const Eigen::Vector2d& observed) {
    sum += (exact - observed).norm();
  });
  EXPECT_GT(sum / 2400, 0.2);
  for (const Eigen::Vector3d& point : simulated.true_pattern.boards[0].points)
    EXPECT_EQ(point.z(), 0);
  EXPECT_EQ(FormatFeatures(simulated.dataset),
            FormatFeatures(Simulate(options).dataset));
}

TEST(SimulateRig, CamerasSeeOneBendOfABoard) {
  SimulationOptions options = FewImages();
  options.noise_px = 0;
  options.board_deformation_m = 0.001;
  options.features_per_image = 1000;
  const auto camera =
      std::make_shared<SimulatedCamera>(ExampleSimulatedCamera());
  const SimulatedRigObservations simulated = SimulateRig(
      MakeCameraRow(camera, 2, 0), ChessboardPattern(18, 12, 0.03), options);
  EXPECT_FALSE(simulated.datasets[0].images.empty());
  EXPECT_EQ(FormatFeatures(simulated.datasets[0]),
            FormatFeatures(simulated.datasets[1]));
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
