#include "calibration_input.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>

#include "crc32.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/text_encoding.h"
#include "features/camera_refinement.h"
#include "features/feature_detection.h"
#include "interruption.h"

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

}  // namespace

Measurements Measure(const std::vector<std::string>& paths,
                     const Pattern& pattern, const CommonOptions& common,
                     const std::function<void(double)>& progress) {
  const DetectionCache cache(DetectionCache::DefaultFolder());
  FolderDetection detection =
      DetectFeatures(paths, pattern, {}, &cache, common.threads, progress);
  for (const SkippedImage& skipped : detection.skipped)
    fmt::print(stderr, "raygrid: skipped {}: {}\n", Printable(skipped.path),
               Printable(skipped.reason));
  if (!common.quiet)
    for (const std::string& remark : SummarizeRemarks(detection))
      fmt::print(stderr, "raygrid: {}\n", Printable(remark));
  return {std::move(detection.dataset), std::move(detection.paths)};
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
    return RefineThroughCamera(measurements.paths, measurements.dataset,
                               {&camera, &found_pattern, poses}, {},
                               num_threads, nullptr);
  };
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
  options.should_stop = IsInterrupted;
  options.progress = [bar](const std::string& stage, double done) {
    bar->Show(stage, 0.2 + 0.7 * done);
  };
  return options;
}

PackedCamera PackForReport(const CameraFile& file, int num_threads) {
  PackOptions options;
  options.remaps = {MakeVirtualCamera(*file.camera, {}, 0)};
  options.num_threads = num_threads;
  return PackCamera(file, options);
}

PackingFigures FiguresOf(const PackedCamera& packed) {
  return {packed.blob.size(), packed.unproject_error_px,
          packed.remaps.empty() ? std::nullopt
                                : std::optional(packed.remaps[0].error_px)};
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

void PrintUncertainty(const CameraUncertainty& uncertainty,
                      const CameraModel& camera) {
  fmt::print(
      "  uncertainty: median {:.4f} px, trusted to {:.4f} px: {:.0f} % of the "
      "image\n",
      uncertainty.lattice.MedianPx(), uncertainty.max_deviation_px,
      100 * uncertainty.TrustedPart(camera.image_size(), camera.area()));
}

std::string InputsOf(const CalibrateArguments& arguments,
                     const std::vector<Measurements>& cameras,
                     const Pattern& pattern) {
  std::string text = FormatPattern(pattern);
  for (const Measurements& camera : cameras)
    text += FormatFeatures(camera.dataset) +
            fmt::format("{} {} {}", camera.dataset.image_size.width,
                        camera.dataset.image_size.height, camera.paths.size());
  text += fmt::format("{} {} {} {} {}", arguments.model, arguments.cell_px,
                      arguments.flat_board, arguments.measure_once,
                      fmt::join(arguments.hold_out, ","));
  return fmt::format("{:08x}",
                     rg_crc32(0, reinterpret_cast<const uint8_t*>(text.data()),
                              static_cast<uint32_t>(text.size())));
}

}  // namespace raygrid
