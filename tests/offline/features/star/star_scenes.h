// Images of star boards through simulated lenses, with the truth beside them,
// and how far detected features are from it.
#ifndef RAYGRID_TESTS_OFFLINE_FEATURES_STAR_STAR_SCENES_H
#define RAYGRID_TESTS_OFFLINE_FEATURES_STAR_STAR_SCENES_H

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "features/pattern_detector.h"
#include "features/star/star_detection.h"
#include "simulation/image_rendering.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"
#include "support.h"

namespace raygrid {

inline constexpr ImageSize kSize = {640, 480};
inline constexpr double kNoise = 2;  // grey levels
inline constexpr int kThreads = 1;
inline constexpr double kSquare = 0.012;

inline std::string BoardYaml(int id, int columns, int rows, int segments,
                             int tag, int tag_column, int tag_row) {
  const auto text = [](int number) { return std::to_string(number); };
  return "  - {id: " + text(id) + ", kind: star, columns: " + text(columns) +
         ", rows: " + text(rows) +
         ", square_m: 0.012, segments: " + text(segments) +
         ", tags: [{family: tag36h11, id: " + text(tag) +
         ", column: " + text(tag_column) + ", row: " + text(tag_row) +
         ", squares: 4}]}\n";
}

inline Pattern PatternOf(const std::string& boards) {
  return ParsePattern("pattern", "raygrid_pattern: 1\nboards:\n" + boards);
}

inline Pattern StarPattern(int segments = 16, int tag = 0) {
  return PatternOf(BoardYaml(0, 16, 15, segments, tag, 6, 5));
}

inline Pattern TwoBoards() {
  return PatternOf(BoardYaml(0, 10, 12, 16, 0, 3, 4) +
                   BoardYaml(1, 10, 12, 16, 1, 3, 4));
}

inline ImagingOptions NoisyImaging(uint64_t seed) {
  ImagingOptions options;  // black 30, white 220, blur 0.7
  options.read_noise = kNoise;
  options.seed = seed;
  return options;
}

/// A quarter of the samples that images usually have, which takes most of the
/// time: for tests whose bounds are far above what that adds.
inline ImagingOptions FewSamples() {
  ImagingOptions options;
  options.samples_per_pixel = 4;
  return options;
}

inline GreyImage WithoutNoise(const RenderedImage& exact) {
  GreyImage image;
  image.size = exact.size;
  image.levels = exact.levels;
  for (const float level : exact.levels)
    image.bytes.push_back(static_cast<uint8_t>(std::lround(level)));
  return image;
}

inline GreyImage WithNoise(const RenderedImage& exact, uint64_t seed) {
  return MakeGreyImage(AddNoiseAndQuantize(exact, NoisyImaging(seed)));
}

struct Shot {
  Pose pose;
  RenderedImage exact;
};

// A lens and a board in front of it.
struct Scene {
  std::unique_ptr<CameraModel> camera;
  Board board;
  std::vector<Shot> shots;

  std::vector<Feature> Truth(const Shot& shot) const {
    return VisibleFeatures(*camera, board, shot.pose);
  }
};

// Without a tag nothing is found.
inline bool ShowsTag(const CameraModel& camera, const Board& board,
                     const Pose& pose) {
  const BoardTag& tag = board.tags[0];
  for (const int u : {0, tag.squares}) {
    for (const int v : {0, tag.squares}) {
      const auto corner =
          camera.Project(pose * Eigen::Vector3d((tag.column + u) * kSquare,
                                                (tag.row + v) * kSquare, 0));
      if (!corner || !WholeImage(kSize).Contains(*corner)) return false;
    }
  }
  return true;
}

// Poses in which the tag is wholly seen.
inline std::vector<Pose> ChoosePoses(const CameraModel& camera,
                                     const Board& board, double min_square_px,
                                     int count, uint64_t seed) {
  PoseOptions options;
  options.min_square_px = min_square_px;
  std::vector<Pose> chosen;
  for (const Pose& pose : RandomPoses(camera, board.points.back() / 2, kSquare,
                                      6 * count, options, seed))
    if (static_cast<int>(chosen.size()) < count &&
        ShowsTag(camera, board, pose))
      chosen.push_back(pose);
  return chosen;
}

inline Scene MakeScene(const std::string& lens, const Pattern& pattern,
                       double min_square_px, int num_images, uint64_t seed,
                       const ImagingOptions& imaging = ImagingOptions()) {
  Scene scene;
  scene.camera = MakeSimulatedCamera(lens, kSize);
  scene.board = pattern.boards[0];
  const PixelRays rays(*scene.camera, kThreads);
  const BoardSurface surface(scene.board);
  for (const Pose& pose :
       ChoosePoses(*scene.camera, scene.board, min_square_px, num_images, seed))
    scene.shots.push_back(
        {pose, RenderImage(rays, {{&surface, pose}}, imaging, kThreads)});
  return scene;
}

// The three lenses, made when first asked for.
inline const Scene& SceneOf(const std::string& lens) {
  static std::map<std::string, Scene> scenes;
  const auto found = scenes.find(lens);
  if (found != scenes.end()) return found->second;
  constexpr int kNumImages = 6;
  return scenes[lens] = MakeScene(lens, StarPattern(), 16, kNumImages, 5);
}

// Differences from the truth, by axis.
struct Errors {
  Eigen::Array2d sum = {0, 0}, sum_of_squares = {0, 0};
  int count = 0;
  double largest = 0;
  int num_visible = 0, num_visible_found = 0;

  Eigen::Array2d Mean() const { return sum / std::max(1, count); }
  Eigen::Array2d Rms() const {
    return (sum_of_squares / std::max(1, count)).sqrt();
  }
  double FoundFraction() const {
    return num_visible_found / std::max<double>(1, num_visible);
  }
};

inline void Add(const Eigen::Vector2d& error, Errors* errors) {
  errors->sum += error.array();
  errors->sum_of_squares += error.array().square();
  errors->largest = std::max(errors->largest, error.norm());
  ++errors->count;
}

inline void Print(const std::string& name, const Errors& errors) {
  std::printf(
      "%s: %d features, RMS %.5f %.5f, mean %.5f %.5f, largest %.4f px; found "
      "%d of %d (%.2f %%)\n",
      name.c_str(), errors.count, errors.Rms().x(), errors.Rms().y(),
      errors.Mean().x(), errors.Mean().y(), errors.largest,
      errors.num_visible_found, errors.num_visible,
      100 * errors.FoundFraction());
}

// Whether a star's square is seen, more than 12 px wide.
inline bool IsWhollyVisible(const CameraModel& camera, const Pose& pose,
                            int column, int row) {
  const auto project = [&](double u, double v) {
    return camera.Project(
        pose * Eigen::Vector3d((column + u) * kSquare, (row + v) * kSquare, 0));
  };
  const Area pixels = WholeImage(kSize);
  for (const double u : {-0.5, 0.5}) {
    for (const double v : {-0.5, 0.5}) {
      const auto corner = project(u, v);
      if (!corner || !pixels.Contains(*corner)) return false;
    }
  }
  constexpr double kMinWidth = 12;
  const double width = (*project(0.5, 0) - *project(-0.5, 0)).norm();
  const double height = (*project(0, 0.5) - *project(0, -0.5)).norm();
  return std::min(width, height) > kMinWidth;
}

using FeatureKey = std::pair<int, int>;

inline void Compare(const Scene& scene, const Shot& shot,
                    const std::vector<Feature>& found, Errors* errors) {
  std::map<FeatureKey, Eigen::Vector2d> truth;
  for (const Feature& feature : scene.Truth(shot))
    truth[{feature.row, feature.column}] = feature.pixel;
  std::map<FeatureKey, int> has;
  for (const Feature& feature : found) {
    const FeatureKey key(feature.row, feature.column);
    ++has[key];
    ASSERT_EQ(truth.count(key), 1u) << feature.pixel.transpose();
    Add(feature.pixel - truth[key], errors);
  }
  for (const auto& [key, pixel] : truth) {
    if (!IsWhollyVisible(*scene.camera, shot.pose, key.second, key.first))
      continue;
    ++errors->num_visible;
    errors->num_visible_found += has.count(key);
  }
}

inline Errors Measure(const Scene& scene, const StarDetector& detector,
                      bool noisy) {
  Errors errors;
  uint64_t seed = 100;
  for (const Shot& shot : scene.shots) {
    const GreyImage image =
        noisy ? WithNoise(shot.exact, seed++) : WithoutNoise(shot.exact);
    Compare(scene, shot, detector.Detect(image).features, &errors);
  }
  return errors;
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_FEATURES_STAR_STAR_SCENES_H
