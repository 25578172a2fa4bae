// Times whole calibrations of simulated cameras with the defaults of
// `raygrid calibrate`, stage by stage. Run by hand:
//   calibration_bench [--case many-features]... [--threads N]

#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "calibration/calibration.h"
#include "dataset/memory_retention.h"
#include "dataset/parallel_for.h"
#include "evaluation/model_difference.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

struct Case {
  std::string name, lens;
  ImageSize size;
  int num_images, features_per_image;
  double shared_noise_px = 0;  ///< that neighbours on the board share
};

std::vector<Case> Cases() {
  return {{"many-features", "example", {640, 480}, 83, 240},
          {"large-images", "wide", {6016, 4016}, 149, 100},
          {"many-images", "wide", {1280, 1024}, 1000, 240},
          {"correlated", "example", {640, 480}, 82, 330, 0.03}};
}

double WallSeconds() {
  return std::chrono::duration<double>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

// Processor time of all threads; less disturbed by other programs.
double ProcessorSeconds() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
}

double PeakGigabytes() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1e6;
}

void TimeCalibration(const Case& c, int num_threads) {
  const Pattern pattern = ChessboardPattern(20, 15, 0.03);
  SimulationOptions simulation;
  simulation.num_images = c.num_images;
  simulation.features_per_image = c.features_per_image;
  simulation.shared_noise_px = c.shared_noise_px;
  const auto truth = MakeSimulatedCamera(c.lens, c.size);
  CalibrationInput input;
  input.dataset = SimulateObservations(*truth, pattern, simulation).dataset;
  CalibrationOptions options;
  options.compare_models = true;
  options.num_threads = num_threads;
  const size_t num_features = input.dataset.num_features();
  const double wall = WallSeconds(), processor = ProcessorSeconds();
  const RigResult result = Calibrate({std::move(input)}, pattern, options);
  std::printf("%s: %d images, %zu features, %d x %d px, %d threads\n",
              c.name.c_str(), c.num_images, num_features, c.size.width,
              c.size.height, NumThreads(num_threads));
  for (const auto& [stage, seconds] : result.seconds)
    std::printf("  %-18s %7.2f s\n", stage.c_str(), seconds);
  const CameraModel& camera = *result.cameras.front().camera.camera;
  std::printf(
      "  %-18s %7.2f s, %.2f processor seconds, %.2f GB\n"
      "  %d parameters, median ray error %.4f px\n",
      "all", WallSeconds() - wall, ProcessorSeconds() - processor,
      PeakGigabytes(), camera.NumParameters(),
      CompareModels(*truth, camera, 10).median_px);
  std::fflush(stdout);
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  raygrid::RetainFreedMemory();  // as raygrid does
  CLI::App app("Times whole calibrations of simulated cameras.");
  std::vector<std::string> names, all;
  for (const raygrid::Case& c : raygrid::Cases()) all.push_back(c.name);
  int num_threads = 2;
  app.add_option("--case", names, "default: all")->check(CLI::IsMember(all));
  app.add_option("--threads", num_threads, "0 means all cores")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  CLI11_PARSE(app, argc, argv);
  for (const raygrid::Case& c : raygrid::Cases()) {
    bool is_asked = names.empty();
    for (const std::string& name : names) is_asked |= name == c.name;
    if (is_asked) raygrid::TimeCalibration(c, num_threads);
  }
  return 0;
}
