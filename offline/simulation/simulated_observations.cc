#include "simulation/simulated_observations.h"

#include <fmt/format.h>

#include <cmath>

#include "dataset/error.h"
#include "simulation/board_curvature.h"
#include "simulation/board_deformation.h"

namespace raygrid {
namespace {

// Returns the direction of a random pixel of the area.
Eigen::Vector3d RandomRay(const CameraModel& camera, const Area& area,
                          Random* random) {
  for (;;) {
    const double x = random->Uniform(area.x0, area.x1);
    const double y = random->Uniform(area.y0, area.y1);
    const auto direction = camera.Unproject({x, y});
    if (direction && camera.IsInImageCircle({x, y})) return *direction;
  }
}

// Returns the pose of a board whose centre is on the ray, and which faces the
// camera with random tilt and rotation about its centre.
Pose MakeRandomTilt(const Eigen::Vector3d& ray, double distance_m,
                    double max_tilt_rad, double max_rotation_rad,
                    const Eigen::Vector3d& center_m, Random* random) {
  const Eigen::Quaterniond facing =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), ray);
  const double direction = random->Uniform(0, 2 * M_PI);
  const Eigen::AngleAxisd tilt(
      random->Uniform(0, max_tilt_rad),
      Eigen::Vector3d(std::cos(direction), std::sin(direction), 0));
  // Full rotations are sampled from 0 on, smaller ones symmetrically about the
  // upright orientation.
  const double first = max_rotation_rad < M_PI ? -max_rotation_rad : 0;
  const Eigen::AngleAxisd turn(
      random->Uniform(first, first + 2 * max_rotation_rad),
      Eigen::Vector3d::UnitZ());
  const Eigen::Quaterniond rotation = facing * tilt * turn;
  return {rotation, ray * distance_m - rotation * center_m};
}

// Returns the pose of a board whose centre projects to a random pixel, with
// random distance, tilt and rotation.
Pose RandomPose(const CameraModel& camera, const Board& board, Random* random) {
  const Area& area = camera.area();
  const Eigen::Vector3d ray = RandomRay(camera, area, random);
  const auto left = camera.Unproject({area.x0, area.center().y()});
  const auto right = camera.Unproject({area.x1, area.center().y()});
  const double angle_of_view =
      left && right ? std::acos(left->dot(*right)) : M_PI / 2;
  const double extent_m = board.columns * board.square_m;
  const double distance_m =
      extent_m / angle_of_view * random->Uniform(0.6, 2.0);
  const Eigen::Vector3d center((board.columns - 1) * board.square_m / 2,
                               (board.rows - 1) * board.square_m / 2, 0);
  return MakeRandomTilt(ray, distance_m, M_PI / 3, M_PI, center, random);
}

// Returns the minimum angular resolution around a ray over all directions, in
// pixels per radian.
double ComputeMagnification(const CameraModel& camera,
                            const Eigen::Vector3d& ray) {
  LinearizedProjection projection;
  if (!camera.Linearize(ray, nullptr, 1, &projection)) return 0;
  const Eigen::Matrix2d square =
      projection.J_point * projection.J_point.transpose();
  const double mean = square.trace() / 2;
  const double root =
      std::sqrt(std::max(0.0, mean * mean - square.determinant()));
  return std::sqrt(std::max(0.0, mean - root));
}

// Adds spatially correlated noise: a sum of random waves, which approaches a
// Gaussian field with the covariance exp(-d^2 / (2 length^2)) at a distance of
// d features.
void AddSharedNoise(double noise_px, double length, Random* random,
                    std::vector<Feature>* features) {
  constexpr int kWaves = 64;
  if (noise_px == 0) return;
  for (int k = 0; k < 2; ++k)
    for (int wave = 0; wave < kWaves; ++wave) {
      const double x = random->Normal() / length;
      const double y = random->Normal() / length;
      const double phase = random->Uniform(0, 2 * M_PI);
      for (Feature& feature : *features)
        feature.pixel[k] +=
            noise_px * std::sqrt(2.0 / kWaves) *
            std::cos(x * feature.column + y * feature.row + phase);
    }
}

}  // namespace

void SubsampleFeatures(size_t count, Random* random,
                       std::vector<Feature>* features) {
  while (features->size() > count)
    features->erase(features->begin() +
                    random->Index(static_cast<int>(features->size())));
}

void AddNoise(const SimulationOptions& options, Random* random,
              std::vector<Feature>* features) {
  for (Feature& feature : *features)
    for (int k = 0; k < 2; ++k)
      feature.pixel[k] += options.noise_px * random->Normal();
  AddSharedNoise(options.shared_noise_px, options.shared_noise_features, random,
                 features);
}

std::vector<Feature> VisibleFeatures(const CameraModel& camera,
                                     const Board& board, const Pose& pose) {
  std::vector<Feature> features;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      if (!board.HasFeature(column, row)) continue;
      const std::optional<Eigen::Vector2d> pixel =
          camera.Project(pose * board.points[board.PointIndex(column, row)]);
      if (pixel && WholeImage(camera.image_size()).Contains(*pixel) &&
          camera.IsInImageCircle(*pixel))
        features.push_back({board.id, column, row, *pixel});
    }
  }
  return features;
}

std::vector<Pose> RandomPoses(const CameraModel& camera,
                              const Eigen::Vector3d& center_m, double square_m,
                              int count, const PoseOptions& options,
                              uint64_t seed) {
  Random random(seed);
  std::vector<Pose> poses;
  const Area image = WholeImage(camera.image_size());
  while (static_cast<int>(poses.size()) < count) {
    const Eigen::Vector3d ray = RandomRay(camera, image, &random);
    const double magnification = ComputeMagnification(camera, ray);
    if (!(magnification > 0)) continue;
    const double square_px =
        random.Uniform(options.min_square_px, options.max_square_px);
    poses.push_back(MakeRandomTilt(
        ray, square_m * magnification / square_px, options.max_tilt_rad,
        options.max_rotation_rad, center_m, &random));
  }
  return poses;
}

SimulatedObservations SimulateObservations(const CameraModel& camera,
                                           const Pattern& pattern,
                                           const SimulationOptions& options) {
  constexpr int kMaxTries = 10000;  // per image
  Random random(options.seed);
  SimulatedObservations result;
  result.dataset.image_size = camera.image_size();
  result.true_pattern = pattern;
  Board& board = result.true_pattern.boards.front();
  board = CurveBoard(board, options.board_sagitta_m);

  int num_tries = 0;
  std::vector<ImageFeatures>& images = result.dataset.images;
  while (static_cast<int>(images.size()) <
         options.num_images * options.num_shots) {
    if (++num_tries > kMaxTries)
      throw Error(ExitCode::kInsufficientData,
                  fmt::format("none of {} random poses shows {} features; "
                              "reduce --features-per-image",
                              kMaxTries, options.features_per_image));
    const Pose pose = RandomPose(camera, board, &random);
    std::vector<Feature> features = VisibleFeatures(
        camera, DeformBoard(board, options.board_deformation_m, &random), pose);
    if (static_cast<int>(features.size()) < options.features_per_image)
      continue;
    num_tries = 0;
    SubsampleFeatures(options.features_per_image, &random, &features);
    for (int shot = 0; shot < options.num_shots; ++shot) {
      const std::string name = fmt::format("sim{:04d}.png", images.size());
      images.push_back({name, features});
      AddNoise(options, &random, &images.back().features);
      result.poses.push_back({name, board.id, pose});
    }
  }
  return result;
}

}  // namespace raygrid
