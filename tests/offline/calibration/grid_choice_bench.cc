// Compares the cells that calibrations choose with others, by the true errors
// of simulated cameras. Run by hand:
//   grid_choice_bench [--lens wide]... [--images 40]... [--seeds N]

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "calibration/calibration.h"
#include "dataset/memory_retention.h"
#include "evaluation/model_difference.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

constexpr ImageSize kSize = {640, 480};
constexpr int kCells[] = {8, 16, 24, 48};  // along the longer side

// The true median error, px; *cell_px becomes what is chosen, where it is 0.
double TrueErrorPx(const CameraModel& truth, const Dataset& dataset,
                   const Pattern& pattern, double* knot_spacing_px) {
  CalibrationInput input;
  input.dataset = dataset;
  CalibrationOptions options;
  options.compare_models = false;
  options.knot_spacing_px = *knot_spacing_px;
  const RigResult result = Calibrate({std::move(input)}, pattern, options);
  *knot_spacing_px = result.cameras.front().knot_spacing_px;
  return CompareModels(truth, *result.cameras.front().camera.camera, 10)
      .median_px;
}

void TryCells(const std::string& lens, int num_images, int num_seeds,
              double noise_px) {
  const Pattern pattern = ChessboardPattern(20, 15, 0.03);
  const auto truth = MakeSimulatedCamera(lens, kSize);
  std::printf("%-10s %4d images:", lens.c_str(), num_images);
  // Geometric means over seeds.
  double chosen_px = 0;
  std::vector<double> errors_px(std::size(kCells));
  for (int seed = 1; seed <= num_seeds; ++seed) {
    SimulationOptions simulation;
    simulation.num_images = num_images;
    simulation.noise_px = noise_px;
    simulation.seed = seed;
    const Dataset dataset =
        SimulateObservations(*truth, pattern, simulation).dataset;
    double knot_spacing_px = 0;
    chosen_px +=
        std::log(TrueErrorPx(*truth, dataset, pattern, &knot_spacing_px)) /
        num_seeds;
    std::printf(" %.0f", kSize.width / knot_spacing_px);
    std::fflush(stdout);
    for (size_t i = 0; i < errors_px.size(); ++i) {
      knot_spacing_px = kSize.width / static_cast<double>(kCells[i]);
      errors_px[i] +=
          std::log(TrueErrorPx(*truth, dataset, pattern, &knot_spacing_px)) /
          num_seeds;
    }
  }
  std::printf(" cells chosen: %.5f px; with", std::exp(chosen_px));
  for (size_t i = 0; i < errors_px.size(); ++i)
    std::printf(" %d: %.5f", kCells[i], std::exp(errors_px[i]));
  std::printf(" px\n");
  std::fflush(stdout);
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  raygrid::RetainFreedMemory();  // as raygrid does
  CLI::App app("Compares the cells that are chosen with others.");
  std::vector<std::string> lenses = {"wide", "fisheye", "fisheye190", "glass",
                                     "example"};
  std::vector<int> images = {10, 40, 160};
  int num_seeds = 3;
  double noise_px = 0.05;
  app.add_option("--lens", lenses, "simulated lenses (default: five)")
      ->check(CLI::IsMember(lenses));
  app.add_option("--images", images, "numbers of images")
      ->capture_default_str();
  app.add_option("--seeds", num_seeds, "how many sets of images of each")
      ->capture_default_str();
  app.add_option("--noise-px", noise_px)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  for (const int num_images : images)
    for (const std::string& lens : lenses)
      raygrid::TryCells(lens, num_images, num_seeds, noise_px);
  return 0;
}
