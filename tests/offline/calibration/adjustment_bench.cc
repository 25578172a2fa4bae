// Times calibrations of simulated cameras, from features to a camera, and tells
// whether the number of threads matters. Run by hand:
//   adjustment_bench [small] [medium] [large] [--threads N]

#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "calibration/camera_initialization.h"
#include "calibration/model_adjustment.h"
#include "dataset/memory_retention.h"
#include "dataset/parallel_for.h"
#include "evaluation/model_difference.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

struct Case {
  const char* name;
  int num_images, features_per_image;
  int board_columns, board_rows;
  double knot_spacing_px;
};

constexpr Case kCases[] = {
    {"small", 100, 200, 20, 15, 29.1},    // 1,000 camera parameters
    {"medium", 1000, 400, 30, 22, 8.15},  // 10,000
    {"large", 1000, 400, 30, 22, 4.0},    // 40,000
};

double Now() {
  return std::chrono::duration<double>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

// CPU time of all threads; less disturbed by other programs.
double CpuSeconds() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) +
           1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double PeakGigabytes() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1e6;
}

struct Run {
  Eigen::VectorXd parameters;
  std::vector<Eigen::Vector3d> points;
};

Run TimeCalibration(const Case& c, int num_threads) {
  const Pattern pattern =
      ChessboardPattern(c.board_columns, c.board_rows, 0.03);
  SimulationOptions simulation;
  simulation.num_images = c.num_images;
  simulation.features_per_image = c.features_per_image;
  const SimulatedCamera truth = ExampleSimulatedCamera();
  const Dataset dataset =
      SimulateObservations(truth, pattern, simulation).dataset;

  AdjustmentOptions options;
  options.num_threads = num_threads;
  const double start = Now(), start_cpu = CpuSeconds();
  AdjustmentResult adjusted = InitializeCamera(dataset, pattern, options);
  const double middle = Now(), middle_cpu = CpuSeconds();
  OptimizeModel(pattern, "central-generic", {c.knot_spacing_px}, options,
                &adjusted);
  AlignBoards(pattern, &adjusted);
  const double end = Now(), end_cpu = CpuSeconds();

  const CameraModel& camera = adjusted.state.camera();
  const ModelDifference difference = CompareModels(truth, camera, 10);
  std::printf(
      "%-7s %4zu views %6zu observations %5d parameters, %d threads: "
      "start %6.2f s, adjustment %6.2f s (CPU %6.2f, %6.2f s); "
      "%.2f GB; median ray error %.5f px\n",
      c.name, adjusted.problem.views.size(), adjusted.summary.residuals.size(),
      camera.NumParameters(), num_threads, middle - start, end - middle,
      middle_cpu - start_cpu, end_cpu - middle_cpu, PeakGigabytes(),
      difference.median_px);
  std::fflush(stdout);
  return {camera.Parameters(), adjusted.state.points};
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  using raygrid::kCases;
  raygrid::RetainFreedMemory();  // as raygrid does
  std::vector<int> threads = {1, 2};
  std::vector<std::string> names;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--threads") == 0 && i + 1 < argc)
      threads = {std::atoi(argv[++i])};
    else
      names.push_back(argv[i]);
  }
  for (const auto& c : kCases) {
    bool asked = names.empty();
    for (const std::string& name : names) asked = asked || name == c.name;
    if (!asked) continue;
    std::vector<raygrid::Run> runs;
    for (const int count : threads)
      runs.push_back(raygrid::TimeCalibration(c, count));
    for (size_t i = 1; i < runs.size(); ++i)
      std::printf("%-7s same with any number of threads: %s\n", c.name,
                  runs[i].parameters == runs[0].parameters &&
                          runs[i].points == runs[0].points
                      ? "yes"
                      : "NO");
  }
  return 0;
}
