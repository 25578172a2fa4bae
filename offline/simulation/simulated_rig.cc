#include "simulation/simulated_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "dataset/error.h"
#include "simulation/board_curvature.h"
#include "simulation/board_deformation.h"
#include "simulation/random.h"

namespace raygrid {
namespace {

// Minimum number of features for a pose estimate.
constexpr size_t kMinFeatures = 8;
// Cosine of the maximum viewing angle at which a board is visible.
constexpr double kMinFacingCosine = 0.2;

// Returns rig_from_board for each frame.
std::vector<Pose> BoardPoses(const SimulatedRig& rig, const Board& board,
                             int first_camera, int count, uint64_t seed) {
  const int num_cameras = static_cast<int>(rig.cameras.size());
  const Eigen::Vector3d center = board.points.back() / 2;
  std::vector<std::vector<Pose>> camera_from_board;
  for (int c = 0; c < num_cameras; ++c)
    camera_from_board.push_back(
        RandomPoses(*rig.cameras[c], center, board.square_m,
                    count / num_cameras + 1, PoseOptions(), seed + c));
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i) {
    const int c = (first_camera + i) % num_cameras;
    poses.push_back(rig.camera_from_rig[c].Inverse() *
                    camera_from_board[c][i / num_cameras]);
  }
  return poses;
}

// Returns first_from_board of each board of a rigid target.
std::vector<Pose> CollectFeaturePositions(const Pattern& pattern,
                                          const FixedBoards& fixed) {
  std::vector<Pose> places = {Pose()};
  for (size_t b = 0; b + 1 < pattern.boards.size(); ++b) {
    const Eigen::Vector3d to_next(
        pattern.boards[b].NominalPoints().back().x() + fixed.gap_m, 0, 0);
    const Eigen::Quaterniond turn(
        Eigen::AngleAxisd(fixed.turn_rad, Eigen::Vector3d::UnitY()));
    places.push_back(places.back() * Pose{turn, to_next});
  }
  return places;
}

// Displaces a board's pose in a random direction.
Pose PerturbPose(const Pose& position, double move_m, Random* random) {
  Eigen::Vector3d direction;
  for (int k = 0; k < 3; ++k) direction[k] = random->Normal();
  direction.normalize();
  return {position.rotation, position.translation + move_m * direction};
}

// Returns rig_from_target for each frame: the centre of a board, or of the gap
// after it, is in front of a camera.
std::vector<Pose> TargetPoses(const SimulatedRig& rig, const Pattern& pattern,
                              const std::vector<Pose>& places, int count,
                              uint64_t seed) {
  constexpr double kMaxTiltRad = 35 * M_PI / 180;
  constexpr double kMaxRotationRad = 25 * M_PI / 180;
  const auto midpoint = [&](size_t board) -> Eigen::Vector3d {
    return places[board] * (pattern.boards[board].NominalPoints().back() / 2);
  };
  const int num_cameras = static_cast<int>(rig.cameras.size());
  std::vector<Eigen::Vector3d> targets;
  for (size_t b = 0; b < places.size(); ++b) {
    targets.push_back(midpoint(b));
    if (b + 1 < places.size())
      targets.push_back((midpoint(b) + midpoint(b + 1)) / 2);
  }
  PoseOptions held;
  held.max_tilt_rad = kMaxTiltRad;
  held.max_rotation_rad = kMaxRotationRad;
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i) {
    const int c = i % num_cameras;
    const Eigen::Vector3d& target = targets[i / num_cameras % targets.size()];
    poses.push_back(rig.camera_from_rig[c].Inverse() *
                    RandomPoses(*rig.cameras[c], target,
                                pattern.boards[0].square_m, 1, held,
                                seed * 1000003 + i)
                        .front());
  }
  return poses;
}

// Distance at which a board fills half of the image.
double HalfFilledDistance(const CameraModel& camera, const Board& board) {
  constexpr double kSlope = 0.01;
  const auto center = camera.Project({0, 0, 1});
  const auto right = camera.Project({kSlope, 0, 1});
  const auto below = camera.Project({0, kSlope, 1});
  if (!center || !right || !below)
    throw Error(ExitCode::kUsage,
                "the camera does not see what is in front of it; boards cannot "
                "be placed around it");
  const Eigen::Vector3d extent_m = board.NominalPoints().back();
  const ImageSize size = camera.image_size();
  return 2 / kSlope *
         std::max(extent_m.x() * (*right - *center).norm() / size.width,
                  extent_m.y() * (*below - *center).norm() / size.height);
}

// Returns rig_from_board of the boards around a rig that has not moved.
std::vector<Pose> BoardsAround(const SimulatedRig& rig,
                               const Pattern& pattern) {
  std::vector<Pose> rig_from_board;
  for (size_t b = 0; b < pattern.boards.size(); ++b) {
    const size_t c = b % rig.cameras.size(), row = b / rig.cameras.size();
    const Board& board = pattern.boards[b];
    const Eigen::Vector3d corner_m = board.NominalPoints().back();
    const double height_m = corner_m.y() + 2 * board.square_m;
    rig_from_board.push_back(
        rig.camera_from_rig[c].Inverse() *
        Pose{Eigen::Quaterniond::Identity(),
             {-corner_m.x() / 2,
              -corner_m.y() / 2 - static_cast<double>(row) * height_m,
              HalfFilledDistance(*rig.cameras[c], board)}});
  }
  return rig_from_board;
}

Eigen::Vector3d RandomVector(const Eigen::Vector3d& largest, Random* random) {
  Eigen::Vector3d vector;
  for (int k = 0; k < 3; ++k)
    vector[k] = random->Uniform(-largest[k], largest[k]);
  return vector;
}

bool IsFrontVisible(const Board& board, const Pose& camera_from_board) {
  const Eigen::Vector3d center = camera_from_board * (board.points.back() / 2);
  const Eigen::Vector3d away =
      camera_from_board.rotation * Eigen::Vector3d::UnitZ();
  return away.dot(center.normalized()) > kMinFacingCosine;
}

std::vector<Feature> Observe(const CameraModel& camera, const Board& board,
                             const Pose& camera_from_board,
                             const SimulationOptions& options, Random* random) {
  if (!IsFrontVisible(board, camera_from_board)) return {};
  std::vector<Feature> features =
      VisibleFeatures(camera, board, camera_from_board);
  if (features.size() < kMinFeatures) return {};
  while (static_cast<int>(features.size()) > options.features_per_image)
    features.erase(features.begin() +
                   random->Index(static_cast<int>(features.size())));
  return features;
}

// Simulates the features of a board in one frame of a camera, with independent
// noise in each shot.
std::vector<std::vector<Feature>> SimulateShots(
    const CameraModel& camera, const Board& board,
    const Pose& camera_from_board, const SimulationOptions& options,
    Random* random) {
  const std::vector<Feature> features =
      Observe(camera, board, camera_from_board, options, random);
  std::vector<std::vector<Feature>> shots(options.num_shots, features);
  for (std::vector<Feature>& shot : shots) AddNoise(options, random, &shot);
  return shots;
}

// Adds the images of all cameras of a frame, numbered from first.
void AddFrame(const SimulatedRig& rig, const std::vector<Board>& boards,
              const std::vector<Pose>& rig_from_board, int first,
              const SimulationOptions& options, Random* random,
              SimulatedRigObservations* result) {
  for (size_t c = 0; c < rig.cameras.size(); ++c) {
    std::vector<ImageFeatures> images(options.num_shots);
    for (int shot = 0; shot < options.num_shots; ++shot)
      images[shot].image = fmt::format("sim{:04d}.png", first + shot);
    for (size_t b = 0; b < boards.size(); ++b) {
      const Pose pose = rig.camera_from_rig[c] * rig_from_board[b];
      const auto shots =
          SimulateShots(*rig.cameras[c], boards[b], pose, options, random);
      for (size_t shot = 0; shot < shots.size(); ++shot) {
        if (shots[shot].empty()) continue;
        images[shot].features.insert(images[shot].features.end(),
                                     shots[shot].begin(), shots[shot].end());
        result->poses[c].push_back({images[shot].image, boards[b].id, pose});
      }
    }
    for (ImageFeatures& image : images)
      if (!image.features.empty())
        result->datasets[c].images.push_back(std::move(image));
  }
}

// Simulates observations of boards with given poses, by board and frame.
SimulatedRigObservations ObserveBoards(
    const SimulatedRig& rig, const Pattern& pattern,
    const std::vector<std::vector<Pose>>& poses,
    const SimulationOptions& options) {
  SimulatedRigObservations result;
  result.true_pattern = pattern;
  result.poses.resize(rig.cameras.size());
  for (const auto& camera : rig.cameras)
    result.datasets.push_back({camera->image_size(), {}});
  for (Board& board : result.true_pattern.boards)
    board = CurveBoard(board, options.board_sagitta_m);
  Random random(options.seed);
  for (int i = 0; i < options.num_images; ++i) {
    // Each board has one deformation per frame, common to all cameras.
    std::vector<Board> boards;
    for (const Board& board : result.true_pattern.boards)
      boards.push_back(
          DeformBoard(board, options.board_deformation_m, &random));
    std::vector<Pose> frame;
    for (size_t b = 0; b < boards.size(); ++b) frame.push_back(poses[b][i]);
    AddFrame(rig, boards, frame, i * options.num_shots, options, &random,
             &result);
  }
  return result;
}

// Removes a board's features from a camera's image if a previous camera
// observes the board in the same frame.
void RemoveSharedViews(SimulatedRigObservations* seen) {
  std::set<std::pair<std::string, int>> shown;
  for (size_t c = 0; c < seen->datasets.size(); ++c) {
    const auto hidden = shown;
    std::vector<ImageFeatures> images;
    for (ImageFeatures& image : seen->datasets[c].images) {
      auto& features = image.features;
      features.erase(
          std::remove_if(
              features.begin(), features.end(),
              [&](const Feature& feature) {
                return hidden.count({image.image, feature.board}) > 0;
              }),
          features.end());
      for (const Feature& feature : features)
        shown.insert({image.image, feature.board});
      if (!features.empty()) images.push_back(std::move(image));
    }
    seen->datasets[c].images = std::move(images);
    auto& poses = seen->poses[c];
    poses.erase(
        std::remove_if(poses.begin(), poses.end(),
                       [&](const BoardPose& pose) {
                         return hidden.count({pose.image, pose.board}) > 0;
                       }),
        poses.end());
  }
}

}  // namespace

SimulatedRig MakeCameraRow(const std::shared_ptr<const CameraModel>& camera,
                           int count, double baseline_m) {
  SimulatedRig rig;
  for (int c = 0; c < count; ++c) {
    rig.cameras.push_back(camera);
    rig.camera_from_rig.push_back(
        {Eigen::Quaterniond::Identity(), {-baseline_m * c, 0, 0}});
  }
  return rig;
}

SimulatedRig MakeCameraRing(const std::shared_ptr<const CameraModel>& camera,
                            int count, double baseline_m, double turn_rad) {
  const auto turn = [](double angle_rad) {
    return Eigen::Quaterniond(
        Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitY()));
  };
  // A chord of the circle, which is at half of the angle.
  const Pose previous_from_next = {
      turn(turn_rad), turn(turn_rad / 2) * Eigen::Vector3d(baseline_m, 0, 0)};
  SimulatedRig rig = {{camera}, {Pose()}};
  while (static_cast<int>(rig.cameras.size()) < count) {
    rig.cameras.push_back(camera);
    rig.camera_from_rig.push_back(previous_from_next.Inverse() *
                                  rig.camera_from_rig.back());
  }
  return rig;
}

SimulatedRigObservations SimulateRig(const SimulatedRig& rig,
                                     const Pattern& pattern,
                                     const SimulationOptions& options) {
  std::vector<std::vector<Pose>> poses;
  for (size_t b = 0; b < pattern.boards.size(); ++b)
    poses.push_back(BoardPoses(rig, pattern.boards[b], static_cast<int>(b),
                               options.num_images,
                               options.seed * 1000003 + 1000 * b));
  return ObserveBoards(rig, pattern, poses, options);
}

SimulatedRigObservations SimulateRig(const SimulatedRig& rig,
                                     const Pattern& pattern,
                                     const FixedBoards& fixed,
                                     const SimulationOptions& options) {
  std::vector<Pose> places = CollectFeaturePositions(pattern, fixed);
  const std::vector<Pose> rigid_targets =
      TargetPoses(rig, pattern, places, options.num_images, options.seed);
  Random random(options.seed);
  const Pose moved = PerturbPose(places.back(), fixed.move_m, &random);
  std::vector<std::vector<Pose>> poses(places.size());
  for (int i = 0; i < options.num_images; ++i) {
    if (2 * i >= options.num_images) places.back() = moved;
    for (size_t b = 0; b < places.size(); ++b)
      poses[b].push_back(rigid_targets[i] * places[b]);
  }
  SimulatedRigObservations seen = ObserveBoards(rig, pattern, poses, options);
  if (fixed.without_shared_views) RemoveSharedViews(&seen);
  return seen;
}

SimulatedRigObservations SimulateRig(const SimulatedRig& rig,
                                     const Pattern& pattern,
                                     const RigMotion& motion,
                                     const SimulationOptions& options) {
  const std::vector<Pose> rig_from_board = BoardsAround(rig, pattern);
  const double distance_m =
      HalfFilledDistance(*rig.cameras.front(), pattern.boards.front());
  Random random(options.seed * 1000003);
  std::vector<std::vector<Pose>> poses(rig_from_board.size());
  for (int i = 0; i < options.num_images; ++i) {
    const Eigen::Quaterniond rotation =
        RotationFromVector(RandomVector(motion.rotation_rad, &random));
    const Pose moved = {rotation,
                        distance_m * RandomVector(motion.translation, &random)};
    for (size_t b = 0; b < rig_from_board.size(); ++b)
      poses[b].push_back(moved * rig_from_board[b]);
  }
  return ObserveBoards(rig, pattern, poses, options);
}

}  // namespace raygrid
