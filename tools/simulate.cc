#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "camera/central_generic.h"
#include "commands.h"
#include "dataset/camera_file.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

struct Arguments {
  SimulationOptions simulation;
  std::string output;
};

// Fine enough that the grid follows the simulated lens to 1e-5 px.
constexpr double kTruthCellPx = 8;

void Run(const Arguments& arguments, const CommonOptions& common) {
  SimulationOptions options = arguments.simulation;
  options.seed = common.seed;
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const Pattern pattern = ChessboardPattern(30, 24, 0.02);
  if (options.features_per_image > pattern.boards[0].num_points())
    throw Error(ExitCode::kUsage,
                fmt::format("--features-per-image: the board has {}",
                            pattern.boards[0].num_points()));
  const SimulatedObservations observations =
      SimulateObservations(camera, pattern, options);
  CameraFile truth;
  truth.name = "simulated";
  truth.camera =
      FitCentralGeneric(camera, camera.area(),
                        NumControlPoints(camera.area().width(), kTruthCellPx),
                        NumControlPoints(camera.area().height(), kTruthCellPx))
          .Clone();
  const std::filesystem::path folder = arguments.output;
  OutputFiles files;
  files.Add((folder / "features.csv").string(),
            FormatFeatures(observations.dataset));
  files.Add((folder / "pattern.yaml").string(), pattern.yaml);
  files.Add((folder / "true_pattern.yaml").string(),
            FormatPattern(observations.true_pattern));
  files.Add((folder / "true_camera.yaml").string(), FormatCameraFile(truth));
  files.Add((folder / "true_poses.csv").string(),
            FormatPoses(observations.poses));
  files.Commit();
  if (!common.quiet)
    fmt::print("{} features in {} images of {} x {} px: {}\n",
               observations.dataset.num_features(),
               observations.dataset.images.size(), camera.image_size().width,
               camera.image_size().height, arguments.output);
}

}  // namespace

void AddSimulate(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "simulate",
      "Observations of a known camera whose lens has local bumps, with the "
      "truth beside them.",
      "raygrid simulate --noise-px 0.05 -o simulated/", common);
  auto arguments = std::make_shared<Arguments>();
  SimulationOptions& simulation = arguments->simulation;
  command->add_option("--images", simulation.num_images, "number of images")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command
      ->add_option("--features-per-image", simulation.features_per_image,
                   "features in each")
      ->check(CLI::Range(1, 720))
      ->capture_default_str();
  command
      ->add_option("--noise-px", simulation.noise_px,
                   "standard deviation of each coordinate")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command
      ->add_option("--board-bend-mm",
                   "how far the board's edges are bent out of its plane")
      ->each([arguments](const std::string& text) {
        arguments->simulation.board_bend_m = std::stod(text) / 1000;
      });
  command->add_option("-o,--output", arguments->output, "folder to write to")
      ->required();
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
