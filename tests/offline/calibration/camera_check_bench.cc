// How often `check` calls unchanged cameras changed, by how they were
// calibrated. Run by hand:
//   camera_check_bench --lens pinhole --model central-generic --images 14

#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>

#include "calibration/calibration.h"
#include "calibration/camera_check.h"
#include "dataset/parallel_for.h"
#include "evaluation/residual_statistics.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

struct Arguments {
  std::string lens = "pinhole", model = "central-generic";
  int width = 640, height = 480;
  int images = 14, features_per_image = 240;
  double bend_mm = 0, noise_px = 0.05, knot_spacing_px = 0;
  bool fix_target_geometry = false;
  int calibrations = 20, draws = 10, draw_images = 5;
  uint64_t seed = 1;
};

Dataset Observe(const Arguments& arguments, int num_images, uint64_t seed) {
  SimulationOptions options;
  options.num_images = num_images;
  options.features_per_image = arguments.features_per_image;
  options.noise_px = arguments.noise_px;
  options.board_sagitta_m = arguments.bend_mm / 1000;
  options.seed = seed;
  return SimulateObservations(
             *MakeSimulatedCamera(arguments.lens,
                                  {arguments.width, arguments.height}),
             ChessboardPattern(30, 24, 0.02), options)
      .dataset;
}

struct Outcome {
  std::string assessment;
  std::vector<CameraChange> changes;
};

Outcome CalibrateAndCheck(const Arguments& arguments, int index) {
  const uint64_t seed = arguments.seed * 1000003 + 1000 * index;
  CalibrationOptions options;
  options.model = arguments.model;
  options.knot_spacing_px = arguments.knot_spacing_px;
  options.fix_target_geometry = arguments.fix_target_geometry;
  options.num_threads = 1;
  const CalibrationResult result =
      Calibrate(Observe(arguments, arguments.images, seed),
                ChessboardPattern(30, 24, 0.02), options);
  Outcome outcome;
  outcome.assessment = result.assessment.word;
  for (int draw = 1; draw <= arguments.draws; ++draw)
    outcome.changes.push_back(
        CheckCamera(result.camera,
                    Observe(arguments, arguments.draw_images, seed + draw),
                    result.pattern, 1)
            .change);
  return outcome;
}

void Run(const Arguments& arguments) {
  std::vector<Outcome> outcomes(arguments.calibrations);
  ParallelFor(arguments.calibrations, NumThreads(0),
              [&](int i) { outcomes[i] = CalibrateAndCheck(arguments, i); });
  int alarms = 0, count = 0;
  std::map<std::string, int> moved, verdicts;
  std::map<std::string, std::vector<double>> sigmas;
  for (const Outcome& outcome : outcomes) {
    ++verdicts[outcome.assessment];
    for (const CameraChange& change : outcome.changes) {
      ++count;
      alarms += change.is_degraded;
      for (const std::string& name : change.moved) ++moved[name];
      for (const Movement& movement : change.movements)
        sigmas[movement.name].push_back(movement.sigmas);
    }
  }
  std::printf("%s, %s, %d images: %d alarms of %d (", arguments.lens.c_str(),
              arguments.model.c_str(), arguments.images, alarms, count);
  for (const auto& [name, number] : moved)
    std::printf(" %s %d", name.c_str(), number);
  std::printf(" );");
  for (const auto& [name, values] : sigmas)
    std::printf(" %s %.2f %.2f", name.c_str(), Quantile(values, 0.5),
                Quantile(values, 0.98));
  for (const auto& [name, number] : verdicts)
    std::printf(" %s %d", name.c_str(), number);
  std::printf("\n");
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  raygrid::Arguments arguments;
  CLI::App app("How often unchanged cameras are called changed.");
  app.add_option("--lens", arguments.lens, "of `simulate`");
  app.add_option("--model", arguments.model, "to calibrate");
  app.add_option("--width", arguments.width, "of images");
  app.add_option("--height", arguments.height, "of images");
  app.add_option("--images", arguments.images, "to calibrate from");
  app.add_option("--features-per-image", arguments.features_per_image);
  app.add_option("--target-deformation-mm", arguments.bend_mm);
  app.add_option("--noise-px", arguments.noise_px);
  app.add_option("--knot-spacing-px", arguments.knot_spacing_px, "0: auto");
  app.add_flag("--fix-target-geometry", arguments.fix_target_geometry);
  app.add_option("--calibrations", arguments.calibrations);
  app.add_option("--draws", arguments.draws, "of new images, each");
  app.add_option("--draw-images", arguments.draw_images);
  app.add_option("--seed", arguments.seed);
  CLI11_PARSE(app, argc, argv);
  raygrid::Run(arguments);
  return 0;
}
