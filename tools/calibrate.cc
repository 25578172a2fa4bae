#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "calibration_input.h"
#include "camera_input.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/image_files.h"
#include "dataset/output_folder.h"
#include "dataset/text_encoding.h"
#include "interruption.h"
#include "packing/blob_camera.h"
#include "pattern_input.h"
#include "report/checkpoint_json.h"
#include "report/pictures.h"
#include "report/result_folder.h"

namespace raygrid {
namespace {

Measurements GivenFeatures(const CalibrateArguments& arguments,
                           const FeaturesByCamera& given) {
  if (arguments.image_sizes.empty())
    throw Error(ExitCode::kUsage, "--features needs --image-size WxH");
  if (arguments.image_sizes.size() > 1)
    throw Error(ExitCode::kUsage,
                "--image-size is given several times, and the features are of "
                "one camera");
  Dataset dataset = given.begin()->second;
  dataset.image_size =
      ParseImageSize("--image-size", arguments.image_sizes.front());
  Measurements measurements = {dataset, {}, {}, {}};
  LeaveOutCopies(&measurements);
  return measurements;
}

// Either detected in images or read.
Measurements GatherFeatures(const CalibrateArguments& arguments,
                            const CommonOptions& common,
                            const FeaturesByCamera& given,
                            const Pattern& pattern, ProgressBar* bar) {
  const Measurements measurements =
      arguments.images.empty()
          ? GivenFeatures(arguments, given)
          : Measure(arguments.images, pattern, arguments.pattern, common,
                    [bar](double done) { bar->Show("detection", 0.2 * done); });
  RequireUsable(
      arguments.features.empty() ? "detected features" : arguments.features,
      arguments, measurements, pattern);
  return measurements;
}

// The first held-out image, or else the first one used; smaller than it was.
std::optional<BeforeAfter> ExampleImage(const std::vector<std::string>& paths,
                                        const CalibrationResult& result,
                                        const CalibrateArguments& arguments,
                                        const std::string& blob) {
  constexpr int kMaxWidthPx = 800;
  const std::string& wanted = arguments.hold_out.empty()
                                  ? result.features.images.front().image
                                  : arguments.hold_out.front();
  for (const std::string& path : paths) {
    if (std::filesystem::path(path).filename() != wanted) continue;
    const Image before = ReadImage(path, true);
    const Image after = BlobCamera("packed camera", blob).Undistort(before, 0);
    return BeforeAfter{Shrunk(before, kMaxWidthPx), Shrunk(after, kMaxWidthPx)};
  }
  return std::nullopt;
}

void PrintSummary(const CalibrateArguments& arguments,
                  const CalibrationResult& result) {
  fmt::print("{}: {} parameters, {} images", result.camera.camera->Name(),
             result.num_parameters, result.features.images.size());
  if (result.cell_px > 0) fmt::print(", cells of {:.0f} px", result.cell_px);
  fmt::print("\n");
  if (result.measured_again_rms_px)
    fmt::print(
        "  features measured again through a first camera: moved by "
        "{:.4f} px (RMS)\n",
        *result.measured_again_rms_px);
  PrintTraining(result);
  if (result.camera.held_out) {
    PrintFigures("held out", *result.camera.held_out);
    if (result.cross_validated) fmt::print("            by cross-validation\n");
  }
  if (result.bias_kl && result.noise_bias_kl)
    fmt::print("  bias (KL divergence) {:.3f}, of pure noise {:.3f}\n",
               *result.bias_kl, *result.noise_bias_kl);
  if (result.camera.uncertainty)
    PrintUncertainty(*result.camera.uncertainty, *result.camera.camera);
  if (result.line_spread)
    fmt::print(
        "  lines pass the point nearest to all by {:.3f} mm (RMS), {:.3f} mm "
        "(largest)\n",
        1000 * result.line_spread->rms_m, 1000 * result.line_spread->max_m);
  fmt::print("  verdict: {}\n", result.verdict.word);
  for (const std::string& reason : result.verdict.reasons)
    fmt::print("    {}\n", Printable(reason));
  fmt::print("  results in {}\n", Printable(arguments.output));
}

void RunSingle(const CalibrateArguments& arguments, const CommonOptions& common,
               const FeaturesByCamera& given) {
  RequireBlobText("--name", arguments.name);
  RequireBlobText("--serial", arguments.serial);
  const Pattern pattern = MeantPattern(arguments.pattern, common);
  RequireNoInputReplaced(arguments, FindImages(arguments.images).paths);
  RequireWritableFolder(arguments.output);

  const std::filesystem::path folder = arguments.output;
  std::string inputs;
  std::vector<std::string> paths;  // of the images
  RigResult results;
  PackedCamera packed;
  Thumbnails thumbnails;
  {
    ProgressBar bar(common.quiet);
    const CalibrationOptions options = OptionsOf(arguments, common, &bar);
    const Measurements measurements =
        GatherFeatures(arguments, common, given, pattern, &bar);
    inputs = InputsOf(arguments, common, {measurements}, pattern);
    CheckpointFile checkpoint(arguments.output, inputs, 1);
    if (arguments.resume) checkpoint.Read();
    const CalibrationInput camera = {
        arguments.name,
        measurements.dataset,
        AgainIn(measurements, arguments, common.threads),
        checkpoint.Of(0),
        [&](const Checkpoint& done) { checkpoint.Keep(0, done); },
        measurements.skipped};
    NoteInterruptions();
    results = Calibrate({camera}, pattern, options);
    CalibrationResult& result = results.cameras.front();
    FinishUndisturbed();
    AddLeftOut(measurements, &result);
    result.camera.serial = arguments.serial;
    bar.Show("packing", 0.9);
    if (!result.checkpoint) {
      packed = PackWhatCanBe(result.camera, common.threads, IsInterrupted);
      thumbnails = MakeThumbnails(measurements.dataset, measurements.paths,
                                  common.threads);
    }
    paths = measurements.paths;
  }

  const CalibrationResult& result = results.cameras.front();
  std::vector<Checkpoint> checkpoints;
  if (result.checkpoint) checkpoints.push_back(*result.checkpoint);
  KeepFinishedResult(arguments.output, checkpoints, inputs);
  CameraExtras own = {packed.blob, {}, {}, std::move(thumbnails)};
  if (!result.checkpoint) own.packing = FiguresOf(packed);
  if (!packed.remaps.empty())
    own.example = ExampleImage(paths, result, arguments, packed.blob);
  OutputFolder output(arguments.output);
  OutputFiles files;
  AddResultFiles(results, {common.seed, PeakMemoryBytes(), {own}},
                 output.path(), &files);
  if (!checkpoints.empty())
    files.Add(output.path() + "/resume.json",
              FormatCheckpoints(checkpoints, inputs));
  files.Commit();
  AddReports(output.path(), &files);
  files.Commit();
  output.Commit(ResultFiles(arguments.output));
  if (common.json)
    fmt::print("{}", ReadFile((folder / "result.json").string()));
  else if (!common.quiet)
    PrintSummary(arguments, result);
  if (!common.quiet) PrintRemarks("camera.raygrid", packed);
  RequireSuccess(result.verdict, result.checkpoint.has_value(),
                 arguments.output);
}

void Run(const CalibrateArguments& arguments, const CommonOptions& common) {
  if (!arguments.images.empty() + !arguments.features.empty() +
          !arguments.cameras.empty() !=
      1)
    throw Error(ExitCode::kUsage, "give either images, --camera or --features");
  FeaturesByCamera given;
  if (!arguments.features.empty()) given = ReadFeatures(arguments.features);
  if (given.size() > 1 || !arguments.cameras.empty())
    RunRig(arguments, common, given);
  else
    RunSingle(arguments, common, given);
}

}  // namespace

void AddCalibrate(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "calibrate",
      "Calibrates a camera, or the cameras of a rig, from images of a pattern "
      "or from features. A rig's files: rig.yaml, NAME/camera.yaml, "
      "NAME/camera.raygrid and NAME/report.html for each camera, and the rest "
      "as for a single one. The first camera's frame is the rig's.",
      "raygrid calibrate photos/ --pattern pattern.yaml -o result/\n"
      "  raygrid calibrate --camera left=l/ --camera right=r/ --pattern "
      "pattern.yaml -o result/",
      common);
  auto arguments = std::make_shared<CalibrateArguments>();
  command->add_option("images", arguments->images, "images or folders");
  command
      ->add_option("--camera", arguments->cameras,
                   "NAME=FOLDER, once for each camera of a rig; images of one "
                   "instant have one name")
      ->type_name("NAME=FOLDER")
      ->allow_extra_args(false);
  command->add_option("--features", arguments->features,
                      "features.csv instead of images; a rig's has a column "
                      "'camera'");
  command
      ->add_option("--image-size", arguments->image_sizes,
                   "WxH, with --features; NAME=WxH for one camera of a rig")
      ->allow_extra_args(false);
  command
      ->add_option("--instant-by", arguments->instant_by,
                   "what tells a rig's images of one instant: their name, or "
                   "the last number in it (left01.jpg and right01.jpg); they "
                   "are called by this number then")
      ->check(CLI::IsMember({"name", "number"}))
      ->capture_default_str();
  AddPatternOption(command, &arguments->pattern)->required();
  AddYes(command, common);
  command
      ->add_option("--model", arguments->model,
                   "central-generic, noncentral-generic, central-radial, "
                   "thin-prism-fisheye or opencv")
      ->capture_default_str();
  command
      ->add_option("--cell-px", arguments->cell_px,
                   "largest cell of the grid; auto chooses by held-out error")
      ->capture_default_str();
  AddHoldOut(command,
             "images (of a rig: instants) to evaluate with instead of "
             "calibrating with them (default: cross-validation)",
             &arguments->hold_out);
  command->add_flag("--flat-board", arguments->flat_board,
                    "trust the pattern's points as they are given");
  command->add_flag("--measure-once", arguments->measure_once,
                    "keep the features as detected; otherwise they are "
                    "measured again through a first camera");
  command->add_flag("--resume", arguments->resume,
                    "go on from where a calibration with the same features, "
                    "options and output folder was interrupted or killed; the "
                    "result is that of one that was not. An interrupted "
                    "calibration writes the best state so far, but not over a "
                    "finished result");
  command->add_flag("--skip-comparison", arguments->skip_comparison,
                    "do not calibrate parametric models as well, to compare "
                    "with in the report");
  command->add_option("--name", arguments->name, "camera's name");
  command->add_option("--serial", arguments->serial, "camera's serial number");
  command->add_option("-o,--output", arguments->output, "folder to write to")
      ->required();
  AddHugeOption(command);
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
