#include <fmt/format.h>
#include <sys/resource.h>

#include <filesystem>
#include <memory>

#include "calibration/calibration.h"
#include "camera_input.h"
#include "commands.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/image_files.h"
#include "features/camera_refinement.h"
#include "features/feature_detection.h"
#include "packing/blob_camera.h"
#include "packing/pack.h"
#include "progress_bar.h"
#include "report/html_report.h"
#include "report/result_json.h"

namespace raygrid {
namespace {

struct Arguments {
  std::vector<std::string> images;
  std::string features, image_size, pattern, output, name, serial;
  std::string model = "central-generic", cell_px = "auto";
  std::vector<std::string> hold_out;
  bool flat_board = false, measure_once = false;
};

// What is calibrated with, and the images that it was measured in, if any.
struct Measurements {
  Dataset dataset;
  std::vector<std::string> paths;  // of the dataset's images
};

int64_t PeakMemoryBytes() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<int64_t>(usage.ru_maxrss) * 1024;
}

double ParseCellPx(const std::string& text) {
  if (text == "auto") return 0;
  char* end;
  const double value = std::strtod(text.c_str(), &end);
  if (*end != 0 || !(value >= 2) || value > 1e5)
    throw Error(
        ExitCode::kUsage,
        fmt::format("--cell-px {}: expected auto, or 2 or more pixels", text));
  return value;
}

Measurements LoadFeatures(const Arguments& arguments) {
  if (arguments.image_size.empty())
    throw Error(ExitCode::kUsage, "--features needs --image-size WxH");
  auto datasets = ReadFeatures(arguments.features);
  if (datasets.size() > 1)
    throw InputError(arguments.features +
                     ": holds several cameras; this version calibrates one, "
                     "split the file by camera");
  Dataset dataset = std::move(datasets.begin()->second);
  dataset.image_size = ParseImageSize("--image-size", arguments.image_size);
  return {dataset, {}};
}

// Images that cannot be used are named, and the others are gone on with.
Measurements Detect(const std::vector<std::string>& paths,
                    const Pattern& pattern, const CommonOptions& common,
                    ProgressBar* bar) {
  const DetectionCache cache(DetectionCache::DefaultFolder());
  FolderDetection detection = DetectFeatures(
      paths, pattern, {}, &cache, common.threads,
      [bar](double done) { bar->Show("detection", 0.2 * done); });
  for (const SkippedImage& skipped : detection.skipped)
    fmt::print(stderr, "raygrid: skipped {}: {}\n", skipped.path,
               skipped.reason);
  return {std::move(detection.dataset), std::move(detection.paths)};
}

// Either detected in images or read.
Measurements GatherFeatures(const Arguments& arguments,
                            const CommonOptions& common,
                            const std::vector<std::string>& paths,
                            const Pattern& pattern, ProgressBar* bar) {
  Measurements measurements = paths.empty()
                                  ? LoadFeatures(arguments)
                                  : Detect(paths, pattern, common, bar);
  const Dataset& dataset = measurements.dataset;
  RequireConsistent(
      arguments.features.empty() ? "detected features" : arguments.features,
      dataset, pattern);
  if (dataset.num_features() == 0)
    throw Error(ExitCode::kTooFew,
                fmt::format("no board found in any of {} images; check columns "
                            "and rows (inner corners) in {}",
                            paths.size(), arguments.pattern));
  return measurements;
}

// The first held-out image, or else the first one used.
std::optional<BeforeAfter> ExampleImage(const std::vector<std::string>& paths,
                                        const CalibrationResult& result,
                                        const Arguments& arguments,
                                        const std::string& blob) {
  const std::string& wanted = arguments.hold_out.empty()
                                  ? result.features.images.front().image
                                  : arguments.hold_out.front();
  for (const std::string& path : paths) {
    if (std::filesystem::path(path).filename() != wanted) continue;
    BeforeAfter example;
    example.name = wanted;
    example.before = ReadImage(path, true);
    example.after =
        BlobCamera("packed camera", blob).Undistort(example.before, 0);
    return example;
  }
  return std::nullopt;
}

PackedCamera Pack(const CameraFile& file, int num_threads) {
  PackOptions options;
  options.remap = MakeVirtualCamera(*file.camera, {}, 0);
  options.num_threads = num_threads;
  return PackCamera(file, options);
}

std::string Report(const std::vector<std::string>& paths,
                   const CalibrationResult& result, const Arguments& arguments,
                   const std::optional<PackedCamera>& packed) {
  if (!packed) return FormatHtmlReport(result, std::nullopt, std::nullopt);
  return FormatHtmlReport(
      result,
      PackingFigures{packed->blob.size(), packed->unproject_error_px,
                     packed->remap_error_px},
      ExampleImage(paths, result, arguments, packed->blob));
}

void PrintSummary(const Arguments& arguments, const CalibrationResult& result) {
  const auto print = [](const char* name, const ErrorFigures& figures) {
    fmt::print(
        "  {:<9} median {:.4f} px, RMS {:.4f} px, largest {:.3f} px, {} "
        "features\n",
        name, figures.median_px, figures.rms_px, figures.max_px, figures.count);
  };
  fmt::print("{}: {} parameters, {} images", result.camera.camera->Name(),
             result.num_parameters, result.features.images.size());
  if (result.cell_px > 0) fmt::print(", cells of {:.0f} px", result.cell_px);
  fmt::print("\n");
  if (result.measured_again_rms_px)
    fmt::print(
        "  features measured again through a first camera: moved by "
        "{:.4f} px (RMS)\n",
        *result.measured_again_rms_px);
  print("training", *result.camera.training);
  if (result.camera.held_out) print("held out", *result.camera.held_out);
  if (result.line_spread)
    fmt::print(
        "  lines pass the point nearest to all by {:.3f} mm (RMS), {:.3f} mm "
        "(largest); no blob, which has no place for lines\n",
        1000 * result.line_spread->rms_m, 1000 * result.line_spread->max_m);
  fmt::print("  verdict: {}\n", result.verdict.word);
  for (const std::string& reason : result.verdict.reasons)
    fmt::print("    {}\n", reason);
  fmt::print("  results in {}\n", arguments.output);
}

CalibrationResult CalibrateWithProgress(const Arguments& arguments,
                                        const CommonOptions& common,
                                        const Measurements& measurements,
                                        const Pattern& pattern,
                                        ProgressBar* bar) {
  CalibrationOptions options;
  options.model = arguments.model;
  options.cell_px = ParseCellPx(arguments.cell_px);
  options.flat_board = arguments.flat_board;
  options.hold_out = arguments.hold_out;
  options.num_threads = common.threads;
  options.progress = [bar](const std::string& stage, double done) {
    bar->Show(stage, 0.2 + 0.7 * done);
  };
  if (!measurements.paths.empty() && !arguments.measure_once)
    options.measure_again = [&](const CameraModel& camera,
                                const Pattern& found_pattern,
                                const std::vector<BoardPose>& poses) {
      return RefineThroughCamera(measurements.paths, measurements.dataset,
                                 {&camera, &found_pattern, poses}, {},
                                 common.threads, nullptr);
    };
  return Calibrate(measurements.dataset, pattern, options);
}

void Run(const Arguments& arguments, const CommonOptions& common) {
  if (arguments.images.empty() == arguments.features.empty())
    throw Error(ExitCode::kUsage, "give either images or --features");
  ParseCellPx(arguments.cell_px);
  const Pattern pattern = ReadPattern(arguments.pattern);
  const std::vector<std::string> paths = FindImages(arguments.images);
  RequireWritableFolder(arguments.output);

  CalibrationResult result;
  std::optional<PackedCamera> packed;
  std::optional<Error> not_packed;  // the other files are worth having even so
  {
    ProgressBar bar(common.quiet);
    const Measurements measurements =
        GatherFeatures(arguments, common, paths, pattern, &bar);
    result =
        CalibrateWithProgress(arguments, common, measurements, pattern, &bar);
    result.camera.name = arguments.name;
    result.camera.serial = arguments.serial;
    bar.Show("packing", 0.9);
    try {
      // Blobs have no place for lines.
      if (result.camera.camera->IsCentral())
        packed = Pack(result.camera, common.threads);
    } catch (const Error& error) {
      not_packed = error;
    }
  }

  const std::string json =
      FormatResultJson(result, common.seed, PeakMemoryBytes());
  const std::filesystem::path folder = arguments.output;
  OutputFiles files;
  files.Add((folder / "camera.yaml").string(), FormatCameraFile(result.camera));
  if (packed) files.Add((folder / "camera.raygrid").string(), packed->blob);
  files.Add((folder / "pattern.yaml").string(), FormatPattern(result.pattern));
  files.Add((folder / "features.csv").string(),
            FormatFeatures(result.features));
  files.Add((folder / "poses.csv").string(), FormatPoses(result.poses));
  files.Add((folder / "result.json").string(), json);
  files.Add((folder / "report.html").string(),
            Report(paths, result, arguments, packed));
  files.Commit();
  if (common.json)
    fmt::print("{}", json);
  else if (!common.quiet)
    PrintSummary(arguments, result);
  if (not_packed) throw *not_packed;
  if (!result.converged)
    throw Error(ExitCode::kNotConverged,
                "the adjustment did not converge; the files hold its last "
                "state, add images or remove blurred ones");
}

}  // namespace

void AddCalibrate(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "calibrate",
      "Calibrates a camera from images of a pattern, or from features.",
      "raygrid calibrate photos/ --pattern pattern.yaml -o result/", common);
  auto arguments = std::make_shared<Arguments>();
  command->add_option("images", arguments->images, "images or folders");
  command->add_option("--features", arguments->features,
                      "features.csv instead of images");
  command->add_option("--image-size", arguments->image_size,
                      "WxH, with --features");
  command->add_option("--pattern", arguments->pattern, "pattern.yaml")
      ->required();
  command
      ->add_option("--model", arguments->model,
                   "central-generic, noncentral-generic, central-radial, "
                   "thin-prism-fisheye or opencv")
      ->capture_default_str();
  command
      ->add_option("--cell-px", arguments->cell_px,
                   "largest cell of the grid; auto chooses by held-out error")
      ->capture_default_str();
  command
      ->add_option("--hold-out", arguments->hold_out,
                   "images to evaluate with instead of calibrating with them "
                   "(default: cross-validation)")
      ->delimiter(',');
  command->add_flag("--flat-board", arguments->flat_board,
                    "trust the pattern's points as they are given");
  command->add_flag("--measure-once", arguments->measure_once,
                    "keep the features as detected; otherwise they are "
                    "measured again through a first camera");
  command->add_option("--name", arguments->name, "camera's name");
  command->add_option("--serial", arguments->serial, "camera's serial number");
  command->add_option("-o,--output", arguments->output, "folder to write to")
      ->required();
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
