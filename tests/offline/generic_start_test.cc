#include "initialization/generic_start.h"

#include <chrono>

#include "evaluation/model_difference.h"
#include "simulation/random.h"
#include "simulation/simulated_lenses.h"
#include "simulation/simulated_observations.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr double kNoisePx = 0.2;

// Boards held all over the image, often partly beyond its edge.
SimulatedObservations Observe(const CameraModel& camera, int num_images,
                              uint64_t seed) {
  SimulatedObservations observations;
  observations.true_pattern = ChessboardPattern(17, 12, 0.02);
  const Board& board = observations.true_pattern.boards[0];
  observations.dataset.image_size = camera.image_size();
  Random noise(seed + 1000);
  for (const Pose& pose : RandomPoses(camera, {0.16, 0.11, 0}, board.square_m,
                                      num_images, {}, seed)) {
    std::vector<Feature> features = VisibleFeatures(camera, board, pose);
    for (Feature& feature : features)
      for (int k = 0; k < 2; ++k) feature.pixel[k] += kNoisePx * noise.Normal();
    const std::string name =
        "image" + std::to_string(observations.poses.size());
    observations.dataset.images.push_back({name, features});
    observations.poses.push_back({name, board.id, pose});
  }
  return observations;
}

TEST(StartFromThreeViews, Measure) {
  for (const char* name : {"pinhole", "wide", "fisheye", "fisheye190"}) {
    for (const int num_images : {20, 60}) {
      for (const uint64_t seed : {1, 2, 3}) {
        const auto camera = SimulatedLens(name, {640, 480});
        const auto observations = Observe(*camera, num_images, seed);
        const auto begin = std::chrono::steady_clock::now();
        const auto start = StartFromThreeViews(observations.dataset,
                                               observations.true_pattern, {});
        const double seconds = std::chrono::duration<double>(
                                   std::chrono::steady_clock::now() - begin)
                                   .count();
        if (!start) {
          printf("%-10s %d images: nothing\n", name, num_images);
          continue;
        }
        const ModelDifference difference =
            CompareModels(*camera, start->camera, 10);
        printf(
            "%-10s %d images seed %d: %zu views, reprojection %.2f px; "
            "median %.2f, rms %.2f, p99 %.2f, max %.2f px, %zu pixels; %.1f "
            "s\n",
            name, num_images, (int)seed, start->views.size(),
            start->median_error_px, difference.median_px, difference.rms_px,
            difference.p99_px, difference.max_px, difference.pixels.size(),
            seconds);
      }
    }
  }
}

}  // namespace
}  // namespace raygrid
