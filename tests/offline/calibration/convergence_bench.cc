// Calibrates simulated cameras with parametric models, and counts those that
// did not converge. Run by hand:
//   convergence_bench [--count 500] [--first 0] [--threads N] [--steps]

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "calibration/camera_initialization.h"
#include "calibration/model_adjustment.h"
#include "dataset/error.h"
#include "dataset/memory_retention.h"
#include "evaluation/residual_statistics.h"
#include "random_calibration.h"

namespace raygrid {
namespace {

// Prints a line, and returns whether it converged.
bool Run(int seed, int num_threads, bool print_steps) {
  const RandomCalibration c = MakeRandomCalibration(seed, 10, 300);
  AdjustmentOptions options;
  options.num_threads = num_threads;
  options.fix_points = c.fix_target_geometry;
  if (print_steps)
    options.progress = [](int iteration, double cost) {
      std::printf("\n  %3d %.8g", iteration, cost);
    };
  std::printf("%3d %-18s of %-10s %3zu images, %5zu features, %s board: ", seed,
              c.model.c_str(), c.lens.c_str(), c.dataset.images.size(),
              c.dataset.num_features(),
              c.fix_target_geometry ? "flat" : "free");
  std::fflush(stdout);
  try {
    AdjustmentResult adjusted = InitializeCamera(c.dataset, c.pattern, options);
    OptimizeModel(c.pattern, c.model, {0}, options, &adjusted);
    std::vector<double> norms;
    for (const Residual& residual : adjusted.summary.residuals)
      if (residual.valid) norms.push_back(residual.error_px.norm());
    std::printf("%s in %2d iterations, median %.4f px\n",
                adjusted.summary.converged ? "converged" : "NOT CONVERGED",
                adjusted.summary.num_iterations, Quantile(norms, 0.5));
    std::fflush(stdout);
    return adjusted.summary.converged;
  } catch (const Error& error) {
    std::printf("%s\n", error.what());
    return error.code() != ExitCode::kNotConverged;
  }
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  CLI::App app("Do calibrations of parametric models converge?");
  int count = 500, first = 0, num_threads = 2;
  app.add_option("--count", count)->capture_default_str();
  app.add_option("--first", first, "seed of the first")->capture_default_str();
  app.add_option("--threads", num_threads)->capture_default_str();
  bool print_steps = false;
  app.add_flag("--steps", print_steps, "print the cost after each step");
  CLI11_PARSE(app, argc, argv);
  raygrid::RetainFreedMemory();  // as raygrid does
  int num_failed = 0;
  for (int seed = first; seed < first + count; ++seed)
    num_failed += !raygrid::Run(seed, num_threads, print_steps);
  std::printf("%d of %d did not converge\n", num_failed, count);
  return num_failed == 0 ? 0 : 1;
}
