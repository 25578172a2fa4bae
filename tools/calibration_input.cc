#include "calibration_input.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <exception>
#include <filesystem>
#include <utility>

#include "dataset/content_hash.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/repeated_images.h"
#include "dataset/text_encoding.h"
#include "features/board_guess.h"
#include "features/pattern_detector.h"
#include "features/refinement/camera_refinement.h"
#include "interruption.h"
#include "report/checkpoint_json.h"
#include "report/result_folder.h"

namespace raygrid {
namespace {

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

struct Interruption {};

// Named by the last part of their paths, as images are everywhere.
std::vector<RejectedImage> SayAndList(const std::vector<SkippedImage>& images) {
  std::vector<RejectedImage> list;
  for (const SkippedImage& image : images) {
    fmt::print(stderr, "raygrid: skipped {}: {}\n", Printable(image.path),
               Printable(image.reason));
    list.push_back(
        {std::filesystem::path(image.path).filename().string(), image.reason});
  }
  return list;
}

}  // namespace

void LeaveOutCopies(Measurements* measurements) {
  Dataset& dataset = measurements->dataset;
  std::vector<std::string>& paths = measurements->paths;
  const std::vector<std::optional<size_t>> repeated = RepeatedImages(dataset);
  std::vector<SkippedImage> copies;
  for (size_t i = 0; i < repeated.size(); ++i)
    if (repeated[i])
      copies.push_back(
          {dataset.images[i].image, "shows the same as " +
                                        dataset.images[*repeated[i]].image +
                                        ", which is used once"});
  for (size_t i = repeated.size(); i-- > 0;) {
    if (!repeated[i]) continue;
    const auto index = static_cast<std::ptrdiff_t>(i);
    dataset.images.erase(dataset.images.begin() + index);
    if (!paths.empty()) paths.erase(paths.begin() + index);
  }
  const std::vector<RejectedImage> named = SayAndList(copies);
  measurements->left_out.insert(measurements->left_out.end(), named.begin(),
                                named.end());
}

Measurements Measure(const std::vector<std::string>& images,
                     const Pattern& pattern, const std::string& pattern_name,
                     const CommonOptions& common,
                     const std::function<void(double)>& progress) {
  const FoundImages found = FindImages(images);
  const DetectionCache cache(DetectionCache::DefaultFolder());
  FolderDetection detection = DetectFeatures(found.paths, pattern, {}, &cache,
                                             common.threads, progress);
  Measurements measurements;
  measurements.skipped = SayAndList(detection.skipped);
  measurements.left_out = SayAndList(found.left_out);
  if (const auto other =
          GuessOtherBoard(detection, pattern, pattern_name, common.threads))
    throw Error(ExitCode::kTooFew, *other);
  if (!common.quiet) {
    for (const std::string& remark : SummarizeRemarks(detection))
      fmt::print(stderr, "raygrid: {}\n", Printable(remark));
    if (!detection.turned.empty())
      fmt::print(stderr, "raygrid: {}\n",
                 Printable(RemarkOnTurned(detection.turned)));
  }
  measurements.dataset = std::move(detection.dataset);
  measurements.paths = std::move(detection.paths);
  LeaveOutCopies(&measurements);
  return measurements;
}

void RequireNoInputReplaced(const CalibrateArguments& arguments,
                            const std::vector<std::string>& images) {
  std::vector<std::string> inputs = images, outputs;
  inputs.push_back(arguments.pattern);
  inputs.push_back(arguments.features);
  for (const char* name :
       {"camera.raygrid", "camera.yaml", "example_after.png",
        "example_before.png", "features.csv", "pattern.yaml", "poses.csv",
        "report.html", "residuals.csv", "result.json", "resume.json",
        "rig.yaml", "thumbnails.json", "uncertainty.png"})
    outputs.push_back(
        (std::filesystem::path(arguments.output) / name).string());
  RequireNoInputReplaced(inputs, outputs);
}

void RequireUsable(const std::string& source,
                   const CalibrateArguments& arguments,
                   const Measurements& measurements, const Pattern& pattern) {
  const Dataset& dataset = measurements.dataset;
  RequireConsistent(source, dataset, pattern);
  if (dataset.num_features() == 0)
    throw Error(ExitCode::kTooFew,
                fmt::format("{}no board found in any of {} images; check "
                            "columns and rows (inner corners) in {}",
                            arguments.cameras.empty() ? "" : source + ": ",
                            dataset.images.size(), arguments.pattern));
}

MeasureAgain AgainIn(const Measurements& measurements,
                     const CalibrateArguments& arguments, int num_threads) {
  if (measurements.paths.empty() || arguments.measure_once) return nullptr;
  return [&measurements, num_threads](const CameraModel& camera,
                                      const Pattern& found_pattern,
                                      const std::vector<BoardPose>& poses) {
    const auto go_on = [](double) {
      if (IsInterrupted()) throw Interruption();
    };
    try {
      return RefineThroughCamera(measurements.paths, measurements.dataset,
                                 {&camera, &found_pattern, poses}, {},
                                 num_threads, go_on);
    } catch (const Interruption&) {
      return measurements.dataset;
    }
  };
}

void AddLeftOut(const Measurements& measurements, CalibrationResult* result) {
  result->rejected_images.insert(result->rejected_images.end(),
                                 measurements.left_out.begin(),
                                 measurements.left_out.end());
}

CalibrationOptions OptionsOf(const CalibrateArguments& arguments,
                             const CommonOptions& common, ProgressBar* bar) {
  CalibrationOptions options;
  options.model = arguments.model;
  options.cell_px = ParseCellPx(arguments.cell_px);
  options.flat_board = arguments.flat_board;
  options.compare_models = !arguments.skip_comparison;
  options.hold_out = arguments.hold_out;
  options.num_threads = common.threads;
  options.any_distance = common.yes;
  options.should_stop = IsInterrupted;
  options.progress = [bar](const std::string& stage, double done) {
    bar->Show(stage, 0.2 + 0.7 * done);
  };
  return options;
}

PackingFigures FiguresOf(const PackedCamera& packed) {
  return {packed.blob.size(), packed.unproject_error_px,
          packed.remaps.empty() ? std::nullopt
                                : std::optional(packed.remaps[0].error_px),
          packed.remarks};
}

void PrintRemarks(const std::string& name, const PackedCamera& packed) {
  for (const std::string& remark : packed.remarks)
    fmt::print(stderr, "raygrid: {}: {}\n", name, remark);
}

int64_t PeakMemoryBytes() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<int64_t>(usage.ru_maxrss) * 1024;
}

void PrintFigures(const char* name, const ErrorFigures& figures) {
  fmt::print(
      "  {:<9} median {:.4f} px, RMS {:.4f} px, largest {:.3f} px, {} "
      "features\n",
      name, figures.median_px, figures.rms_px, figures.max_px, figures.count);
}

void PrintTraining(const CalibrationResult& result) {
  PrintFigures("training", *result.camera.training);
  if (const size_t count = NumWithoutError(result))
    fmt::print(
        "            {} more features are where this camera projects nothing\n",
        count);
}

void PrintUncertainty(const CameraUncertainty& uncertainty,
                      const CameraModel& camera) {
  fmt::print(
      "  uncertainty: median {:.4f} px, trusted to {:.4f} px: {:.0f} % of the "
      "image\n",
      uncertainty.lattice.MedianPx(), uncertainty.max_deviation_px,
      100 * uncertainty.TrustedPart(camera.image_size(), camera.area()));
}

void RequireSuccess(const Verdict& verdict, bool is_interrupted,
                    const std::string& folder) {
  if (is_interrupted)
    throw Error(ExitCode::kNotConverged,
                fmt::format("interrupted; {} holds the best state so far, "
                            "--resume goes on from there",
                            folder));
  if (verdict.word == "fail")
    throw Error(ExitCode::kQuality,
                fmt::format("verdict: fail: {}; do not use the camera in {} "
                            "before that is mended",
                            verdict.failure, folder));
}

void KeepFinishedResult(const std::string& folder,
                        const std::vector<Checkpoint>& checkpoints,
                        const std::string& inputs) {
  if (checkpoints.empty() || !HasFinishedResult(folder)) return;
  OutputFiles files;
  files.Add((std::filesystem::path(folder) / "resume.json").string(),
            FormatCheckpoints(checkpoints, inputs), Links::kReplace);
  files.Commit();
  throw Error(ExitCode::kNotConverged,
              fmt::format("interrupted; {} keeps the finished result that it "
                          "held before, --resume goes on with this one",
                          folder));
}

std::string InputsOf(const CalibrateArguments& arguments,
                     const CommonOptions& common,
                     const std::vector<Measurements>& cameras,
                     const Pattern& pattern) {
  ContentHash hash;
  hash.Add(RAYGRID_VERSION);
  hash.Add(FormatPattern(pattern));
  for (const Measurements& camera : cameras) {
    const ImageSize& size = camera.dataset.image_size;
    hash.Add(
        fmt::format("{} {} {}", size.width, size.height, camera.paths.size()));
    for (const ImageFeatures& image : camera.dataset.images) {
      hash.Add(image.image);
      for (const Feature& f : image.features)
        hash.Add(fmt::format("{} {} {} {:.17g} {:.17g}", f.board, f.column,
                             f.row, f.pixel.x(), f.pixel.y()));
    }
  }
  hash.Add(fmt::format("{} {} {} {} {}", arguments.model, arguments.cell_px,
                       arguments.flat_board, arguments.measure_once,
                       common.seed));
  for (const std::string& image : arguments.hold_out) hash.Add(image);
  return hash.Text();
}

// ---- Checkpoints -----------------------------------------------------------

namespace {
using Clock = std::chrono::steady_clock;
}

CheckpointFile::CheckpointFile(const std::string& folder,
                               const std::string& inputs, size_t num_cameras)
    : path_((std::filesystem::path(folder) / "resume.json").string()),
      inputs_(inputs),
      checkpoints_(num_cameras) {}

void CheckpointFile::Read() {
  std::vector<Checkpoint> read = ReadCheckpoints(path_, inputs_);
  if (read.size() != checkpoints_.size())
    throw InputError(path_ +
                     ": is of a rig of other cameras; run without "
                     "--resume");
  checkpoints_ = std::move(read);
}

void CheckpointFile::Keep(size_t camera, const Checkpoint& checkpoint) {
  checkpoints_[camera] = checkpoint;
  const auto start = Clock::now();
  if (start < next_write_) return;
  try {
    OutputFiles files;
    files.Add(path_, FormatCheckpoints(checkpoints_, inputs_), Links::kReplace);
    files.Commit();
    is_written_ = true;
  } catch (const Error&) {
    // The result is worth having without.
  }
  // Writing takes a tenth of the time at most.
  const auto end = Clock::now();
  next_write_ = end + 9 * (end - start);
}

CheckpointFile::~CheckpointFile() {
  if (is_written_ && std::uncaught_exceptions() > 0) {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
}

}  // namespace raygrid
