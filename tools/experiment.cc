#include "experiments/experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "camera_input.h"
#include "commands.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/rig_file.h"
#include "experiments/calibrated_cameras.h"
#include "experiments/experiment_files.h"
#include "help_formatter.h"
#include "image_size_option.h"
#include "pattern_input.h"
#include "progress_bar.h"
#include "report/result_folder.h"

namespace raygrid {
namespace {

// With --fine-distortion: knot spacings of 20 px and 10 px yield 10,000 and
// 40,000 parameters.
constexpr ImageSize kFineSize = {1840, 1040};
constexpr int kFineImages = 500;

struct ExperimentArguments {
  std::string name, size, output;
  std::string features, image_size, pattern, trajectory, result;
  std::vector<std::string> cameras, rigs, images, hold_out;
  int num_images = 0;
  std::vector<double> bump_widths_px;
  double min_distance_m = 0;
  bool list = false;
  ExperimentOptions options;
};

std::string FormatExperimentList() {
  std::string list;
  for (const Experiment& experiment : Experiments())
    list += fmt::format("  {:<20} {}\n", experiment.name, experiment.summary);
  return list;
}

const Experiment& FindExperiment(const std::string& name) {
  for (const Experiment& experiment : Experiments())
    if (experiment.name == name) return experiment;
  throw Error(
      ExitCode::kUsage,
      fmt::format("experiment {}: unknown; see raygrid experiment --list",
                  name));
}

void RequireUse(const Experiment& experiment,
                const ExperimentArguments& arguments) {
  const auto require = [&experiment](const char* option, bool is_given) {
    const auto& known = experiment.user_options;
    if (is_given &&
        std::find(known.begin(), known.end(), option) == known.end())
      throw Error(ExitCode::kUsage,
                  fmt::format("experiment {} does not support {}",
                              experiment.name, option));
  };
  if (arguments.options.fine && experiment.name != "model-validation")
    throw Error(ExitCode::kUsage,
                fmt::format("experiment {}: does not use --fine-distortion",
                            experiment.name));
  if (arguments.options.fine && !arguments.features.empty())
    throw Error(ExitCode::kUsage,
                "--fine-distortion simulates features and cannot be combined "
                "with --features");
  if (!arguments.bump_widths_px.empty() && !arguments.options.fine)
    throw Error(ExitCode::kUsage, "--bump-px requires --fine-distortion");
  constexpr size_t kMaxWidths = 6;  // the maximum for a chart
  if (arguments.bump_widths_px.size() > kMaxWidths)
    throw Error(ExitCode::kUsage,
                fmt::format("--bump-px: {} values, at most {} are supported",
                            arguments.bump_widths_px.size(), kMaxWidths));
  require("--features", !arguments.features.empty());
  require("--result", !arguments.result.empty());
  require("--camera", !arguments.cameras.empty());
  require("--colmap-model", !arguments.trajectory.empty());
  require("--rig", !arguments.rigs.empty());
  require("--image", !arguments.images.empty());
  require("--min-depth-m", arguments.min_distance_m > 0);
  if (!arguments.features.empty() &&
      (arguments.pattern.empty() || arguments.image_size.empty()))
    throw Error(ExitCode::kUsage,
                "--features requires --pattern and --image-size WxH");
}

// Returns the path of a file, or of that file in a result folder of calibrate.
std::string ResolveFile(const std::string& path, const char* file) {
  return std::filesystem::is_directory(path)
             ? (std::filesystem::path(path) / file).string()
             : path;
}

NamedCamera ReadNamedCamera(const std::string& path) {
  const CameraInput input = ReadCamera(ResolveFile(path, "camera.yaml"));
  return {path, input.file.camera,
          input.blob ? LoadValidityMask(input)
                     : ComputeWellDeterminedMask(input.file)};
}

StereoRig ReadStereo(const std::string& given_path) {
  const std::string path = ResolveFile(given_path, "rig.yaml");
  const std::vector<RigFileCamera> cameras = ReadRigFile(path);
  if (cameras.size() != 2)
    throw InputError(fmt::format("{}: contains {} cameras; stereo requires two",
                                 path, cameras.size()));
  const auto read = [&path](const RigFileCamera& camera) {
    const auto folder = std::filesystem::path(path).parent_path();
    return ReadNamedCamera((folder / camera.file).string());
  };
  const NamedCamera left = read(cameras[0]), right = read(cameras[1]);
  return {given_path,
          left.model,
          right.model,
          cameras[1].camera_from_rig * cameras[0].camera_from_rig.Inverse(),
          left.known,
          right.known};
}

// Reads features of one camera, or of two cameras for stereo.
void ReadUsersFeatures(const ExperimentArguments& arguments,
                       ExperimentData* data) {
  data->pattern = LoadPattern(arguments.pattern);
  const ImageSize size = ParseImageSize("--image-size", arguments.image_size);
  if (arguments.name != "stereo-depth") {
    data->features =
        ReadCameraFeatures(arguments.features, size, data->pattern);
    return;
  }
  auto cameras = ReadFeatures(arguments.features);
  if (cameras.size() != 2)
    throw InputError(fmt::format(
        "{}: contains features of {} camera{}; stereo requires two, named in "
        "the column 'camera'",
        arguments.features, cameras.size(), cameras.size() == 1 ? "" : "s"));
  for (auto& [name, dataset] : cameras) {
    dataset.image_size = size;
    RequireConsistent(arguments.features, dataset, data->pattern);
  }
  data->pair_features = {std::move(cameras.begin()->second),
                         std::move(cameras.rbegin()->second)};
}

CalibrationResult ReadSingleResult(const std::string& folder) {
  RigResult result = ReadResultFolder(folder).result;
  if (result.cameras.size() > 1)
    throw InputError(folder +
                     ": is the result of a rig; the report of each camera has "
                     "its own residual budget");
  return std::move(result.cameras.front());
}

ExperimentData ReadData(const ExperimentArguments& arguments) {
  ExperimentData data;
  data.hold_out = arguments.hold_out;
  for (const std::string& path : arguments.cameras)
    data.cameras.push_back(ReadNamedCamera(path));
  for (const std::string& path : arguments.rigs)
    data.rigs.push_back(ReadStereo(path));
  data.images = arguments.images;
  data.min_distance_m = arguments.min_distance_m;
  if (!arguments.result.empty())
    data.result = ReadSingleResult(arguments.result);
  if (!arguments.trajectory.empty())
    data.trajectory = ReadColmapModel(arguments.trajectory);
  if (!arguments.features.empty()) ReadUsersFeatures(arguments, &data);
  return data;
}

// Returns the common path of an experiment's result files, without extension.
std::string BaseName(const Experiment& experiment, const std::string& folder) {
  return (std::filesystem::path(folder) / experiment.name).string();
}

void RequireInputsStay(const Experiment& experiment,
                       const ExperimentArguments& arguments) {
  const std::vector<std::string> images = FindImages(arguments.images).paths;
  std::vector<std::string> inputs = {arguments.features, arguments.pattern};
  for (const auto& more : {arguments.cameras, arguments.rigs, images})
    inputs.insert(inputs.end(), more.begin(), more.end());
  const std::string base = BaseName(experiment, arguments.output);
  RequireNoInputReplaced(inputs,
                         {base + ".csv", base + ".json", base + ".svg"});
  RequireSeparateFolders(images,
                         arguments.output);  // pictures are also written
}

void WriteResult(const Experiment& experiment, const ExperimentResult& result,
                 const std::string& folder) {
  const std::string base = BaseName(experiment, folder);
  OutputFiles files;
  files.Add(base + ".csv", FormatExperimentCsv(result));
  files.Add(base + ".json", FormatExperimentJson(experiment.name, result));
  files.Add(base + ".svg", MakeChartSvg(result.chart));
  for (const ExperimentImage& picture : result.pictures)
    files.Add(base + "-" + picture.name + ".png", EncodePng(picture.image));
  files.Commit();
}

void Run(const ExperimentArguments& arguments, const CommonOptions& common) {
  if (arguments.list) {
    fmt::print("{}", FormatExperimentList());
    return;
  }
  if (arguments.name.empty() || arguments.output.empty())
    throw Error(ExitCode::kUsage,
                "experiment: specify a name and -o FOLDER, or --list");
  const Experiment& experiment = FindExperiment(arguments.name);
  ExperimentOptions options = arguments.options;
  if (!arguments.size.empty())
    options.size = ParseImageSize("--size", arguments.size);
  else if (options.fine)
    options.size = kFineSize;
  if (arguments.num_images > 0)
    options.num_images = arguments.num_images;
  else
    options.num_images = options.fine ? kFineImages : experiment.num_images;
  RequireUse(experiment, arguments);
  RequireInputsStay(experiment, arguments);
  if (!arguments.bump_widths_px.empty())
    options.bump_widths_px = arguments.bump_widths_px;
  options.data = ReadData(arguments);
  options.seed = common.seed;
  options.num_threads = common.threads;
  RequireCreatableFolder(arguments.output);
  const ExperimentResult result = [&] {
    ProgressBar bar(common.quiet);
    options.progress = [&](double done) { bar.Show(experiment.name, done); };
    return experiment.run(options);
  }();
  WriteResult(experiment, result, arguments.output);
  if (common.json)
    fmt::print("{}", FormatExperimentJson(experiment.name, result));
  else if (!common.quiet)
    fmt::print("{}\n{}.csv, .json and .svg{}: {}\n",
               FormatExperimentText(result), experiment.name,
               result.pictures.empty() ? "" : ", and pictures",
               arguments.output);
}

}  // namespace

void AddExperiment(CLI::App* app, CommonOptions* common) {
  CLI::App* command =
      AddCommand(app, "experiment",
                 "Run an experiment of Schöps et al. (CVPR 2020) on simulated "
                 "or real data.",
                 "raygrid experiment pattern-segments -o results/", common);
  command->footer("Experiments:\n" + FormatExperimentList() + "\n" +
                  command->get_footer());
  auto arguments = std::make_shared<ExperimentArguments>();
  ExperimentOptions& options = arguments->options;
  command->add_option("name", arguments->name, "experiment, see below");
  command
      ->add_option("--result", arguments->result, "output folder of calibrate")
      ->option_text("DIR");
  command
      ->add_option("--features", arguments->features,
                   "features.csv to use instead of simulated features; for "
                   "stereo-depth, features of two cameras")
      ->option_text("FILE");
  command
      ->add_option("--image-size", arguments->image_size,
                   "size in px of the images in which --features were detected")
      ->option_text("WxH");
  AddHoldOut(command, "test images (default: every fifth)",
             &arguments->hold_out);
  command
      ->add_option("--camera", arguments->cameras,
                   "camera.yaml, blob or output folder of calibrate; "
                   "repeatable; the last one is the reference")
      ->option_text("PATH")
      ->allow_extra_args(false);
  command
      ->add_option("--rig", arguments->rigs,
                   "rig.yaml of two cameras, or output folder of calibrate; "
                   "repeatable; the last one is the reference")
      ->option_text("PATH")
      ->allow_extra_args(false);
  command
      ->add_option("--image", arguments->images, "image or folder; repeatable")
      ->option_text("PATH")
      ->allow_extra_args(false);
  command
      ->add_option(
          "--min-depth-m", arguments->min_distance_m,
          "minimum depth of the scene in --image (default: ten baselines)")
      ->option_text("M")
      ->check(AboveZero());
  command
      ->add_option("--colmap-model", arguments->trajectory,
                   "COLMAP text model: folder with cameras.txt, images.txt and "
                   "points3D.txt")
      ->option_text("DIR");
  AddPatternOption(command, &arguments->pattern, "; with --features");
  BeginGroup(command, "Simulation");
  command
      ->add_option("--images", arguments->num_images,
                   "number of images; for capture-guidance, number of cameras "
                   "(default: set by the experiment)")
      ->option_text("N")
      ->check(CLI::Range(1, 10000));
  command
      ->add_option("--trajectories", options.num_trajectories,
                   "number of trajectories, for trajectory-drift")
      ->option_text("N")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command
      ->add_option("--size", arguments->size,
                   fmt::format("image size in px (default: 640x480; {}x{} with "
                               "--fine-distortion)",
                               kFineSize.width, kFineSize.height))
      ->option_text("WxH");
  command->add_flag(
      "--fine-distortion", options.fine,
      fmt::format("model-validation with local distortion of 20 to 60 px, {} "
                  "images and knot spacings of 30, 20 and 10 px (half an hour)",
                  kFineImages));
  command
      ->add_option("--bump-px", arguments->bump_widths_px,
                   "with --fine-distortion: width of the distortions at half "
                   "maximum; repeatable (default: 20, 40, 60)")
      ->option_text("PX")
      ->allow_extra_args(false)
      ->check(CLI::Range(5.0, 500.0));
  command->add_option("--blur-px", options.blur_px, "optical blur, 1 σ")
      ->option_text("PX")
      ->check(CLI::Range(0.0, 50.0))
      ->capture_default_str();
  command->add_option("--read-noise", options.read_noise, "read noise, 1 σ")
      ->option_text("LEVELS")
      ->check(CLI::Range(0.0, 255.0))
      ->capture_default_str();
  BeginGroup(command, help_group::kOutput);
  command
      ->add_option("-o,--output", arguments->output,
                   "folder for tables (NAME.csv, NAME.json) and plots")
      ->option_text("DIR");
  command->add_flag("--list", arguments->list, "list the experiments");
  AddHugeOption(command);
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
