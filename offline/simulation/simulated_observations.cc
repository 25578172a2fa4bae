#include "simulation/simulated_observations.h"

#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <random>

namespace raygrid {
namespace {

// Uniform and normal numbers that do not depend on the standard library's
// implementation.
class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}

  double Uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  // Box and Muller.
  double Normal() {
    const double radius = std::sqrt(-2 * std::log(1 - Uniform(0, 1)));
    return radius * std::cos(Uniform(0, 2 * M_PI));
  }
  int Index(int count) { return static_cast<int>(Uniform(0, count)); }

 private:
  std::mt19937_64 engine_;
};

Board BentBoard(const Board& board, double bend_m) {
  Board bent = board;
  const double cx = (board.columns - 1) * board.square_m / 2;
  const double cy = (board.rows - 1) * board.square_m / 2;
  for (Eigen::Vector3d& point : bent.points) {
    const double x = (point.x() - cx) / cx, y = (point.y() - cy) / cy;
    point.z() += bend_m * (x * x + 0.5 * y * y);
  }
  return bent;
}

// The board's centre looks out of a random pixel, at a random distance, tilt
// and turn.
Pose RandomPose(const CameraModel& camera, const Board& board, Random* random) {
  const Area& area = camera.area();
  Eigen::Vector3d ray;
  for (;;) {
    const auto direction = camera.Unproject(
        {random->Uniform(area.x0, area.x1), random->Uniform(area.y0, area.y1)});
    if (direction) {
      ray = *direction;
      break;
    }
  }
  const auto left = camera.Unproject({area.x0, area.center().y()});
  const auto right = camera.Unproject({area.x1, area.center().y()});
  const double angle_of_view =
      left && right ? std::acos(left->dot(*right)) : M_PI / 2;
  const double extent_m = board.columns * board.square_m;
  const double distance_m =
      extent_m / angle_of_view * random->Uniform(0.6, 2.0);

  const Eigen::Quaterniond facing =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), ray);
  const double direction = random->Uniform(0, 2 * M_PI);
  const Eigen::AngleAxisd tilt(
      random->Uniform(0, M_PI / 3),
      Eigen::Vector3d(std::cos(direction), std::sin(direction), 0));
  const Eigen::AngleAxisd turn(random->Uniform(0, 2 * M_PI),
                               Eigen::Vector3d::UnitZ());
  const Eigen::Quaterniond rotation = facing * tilt * turn;
  const Eigen::Vector3d center((board.columns - 1) * board.square_m / 2,
                               (board.rows - 1) * board.square_m / 2, 0);
  return {rotation, ray * distance_m - rotation * center};
}

std::vector<Feature> VisibleFeatures(const CameraModel& camera,
                                     const Board& board, const Pose& pose) {
  std::vector<Feature> features;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      const auto pixel =
          camera.Project(pose * board.points[board.PointIndex(column, row)]);
      if (pixel) features.push_back({board.id, column, row, *pixel});
    }
  }
  return features;
}

// Keeps count of the features, chosen at random, in their order.
void Thin(size_t count, Random* random, std::vector<Feature>* features) {
  while (features->size() > count)
    features->erase(features->begin() +
                    random->Index(static_cast<int>(features->size())));
}

}  // namespace

SimulatedObservations SimulateObservations(const CameraModel& camera,
                                           const Pattern& pattern,
                                           const SimulationOptions& options) {
  Random random(options.seed);
  SimulatedObservations result;
  result.dataset.image_size = camera.image_size();
  result.true_pattern = pattern;
  Board& board = result.true_pattern.boards.front();
  board = BentBoard(board, options.board_bend_m);

  while (static_cast<int>(result.dataset.images.size()) < options.num_images) {
    const Pose pose = RandomPose(camera, board, &random);
    std::vector<Feature> features = VisibleFeatures(camera, board, pose);
    if (static_cast<int>(features.size()) < options.features_per_image)
      continue;
    Thin(options.features_per_image, &random, &features);
    for (Feature& feature : features)
      for (int k = 0; k < 2; ++k)
        feature.pixel[k] += options.noise_px * random.Normal();
    const std::string name =
        fmt::format("sim{:04d}.png", result.dataset.images.size());
    result.dataset.images.push_back({name, std::move(features)});
    result.poses.push_back({name, board.id, pose});
  }
  return result;
}

}  // namespace raygrid
