#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>

#include "calibration_input.h"
#include "camera_input.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/image_files.h"
#include "dataset/output_folder.h"
#include "dataset/rig_file.h"
#include "dataset/text_encoding.h"
#include "interruption.h"
#include "pattern_input.h"
#include "report/checkpoint_json.h"
#include "report/result_folder.h"

namespace raygrid {
namespace {

// The texts before and after the '=' of NAME=VALUE; all is value without one.
struct NamedValue {
  std::string name, value;
};
NamedValue Parse(const std::string& text) {
  const size_t equals = text.find('=');
  if (equals == std::string::npos) return {"", text};
  return {text.substr(0, equals), text.substr(equals + 1)};
}

// Names become folders and fields of CSV files.
void RequireCameraName(const std::string& name) {
  if (!IsRigCameraName(name))
    throw Error(ExitCode::kUsage,
                fmt::format("camera name '{}': give it one of letters, digits, "
                            "'-' and '_'",
                            name));
}

std::vector<NamedValue> ParseCameras(const CalibrateArguments& arguments) {
  std::vector<NamedValue> cameras;
  std::set<std::string> names;
  for (const std::string& text : arguments.cameras) {
    cameras.push_back(Parse(text));
    const std::string& name = cameras.back().name;
    if (name.empty())
      throw Error(ExitCode::kUsage,
                  fmt::format("--camera {}: expected NAME=FOLDER", text));
    RequireCameraName(name);
    if (!names.insert(name).second)
      throw Error(ExitCode::kUsage,
                  fmt::format("--camera {}: two cameras of one name", name));
  }
  if (cameras.size() == 1)
    throw Error(ExitCode::kUsage,
                "a rig needs two cameras or more; give the images of a single "
                "one without --camera");
  return cameras;
}

// WxH is for all cameras that have no NAME=WxH.
ImageSize SizeOf(const std::string& camera,
                 const CalibrateArguments& arguments) {
  std::string size;
  for (const std::string& text : arguments.image_sizes) {
    const NamedValue given = Parse(text);
    if (given.name == camera || (given.name.empty() && size.empty()))
      size = given.value;
  }
  if (size.empty())
    throw Error(ExitCode::kUsage,
                fmt::format("--features needs --image-size WxH, or "
                            "--image-size {}=WxH for its camera '{}'",
                            camera, camera));
  return ParseImageSize("--image-size", size);
}

void RequireSizesOfCameras(const CalibrateArguments& arguments,
                           const FeaturesByCamera& given) {
  for (const std::string& text : arguments.image_sizes) {
    const std::string name = Parse(text).name;
    if (!name.empty() && !given.count(name))
      throw Error(ExitCode::kUsage,
                  fmt::format("--image-size {}: {} has no camera '{}'", text,
                              arguments.features, name));
  }
}

struct RigMeasurements {
  std::vector<std::string> names;
  std::vector<Measurements> cameras;
};

RigMeasurements GivenFeatures(const CalibrateArguments& arguments,
                              const FeaturesByCamera& given,
                              const Pattern& pattern) {
  RequireSizesOfCameras(arguments, given);
  RigMeasurements rig;
  for (const auto& [name, dataset] : given) {
    RequireCameraName(name);
    rig.names.push_back(name);
    rig.cameras.push_back({dataset, {}, {}, {}});
    rig.cameras.back().dataset.image_size = SizeOf(name, arguments);
    LeaveOutCopies(&rig.cameras.back());
    RequireUsable(arguments.features + ", camera " + name, arguments,
                  rig.cameras.back(), pattern);
  }
  return rig;
}

RigMeasurements MeasureAll(const CalibrateArguments& arguments,
                           const CommonOptions& common, const Pattern& pattern,
                           ProgressBar* bar) {
  const std::vector<NamedValue> cameras = ParseCameras(arguments);
  for (const NamedValue& camera : cameras)
    FindImages({camera.value});  // throws before anything takes long
  RigMeasurements rig;
  for (size_t c = 0; c < cameras.size(); ++c) {
    const std::string& name = cameras[c].name;
    rig.names.push_back(name);
    rig.cameras.push_back(
        Measure({cameras[c].value}, pattern, arguments.pattern, common,
                [&](double done) {
                  bar->Show(name + ": detection",
                            0.2 * (static_cast<double>(c) + done) /
                                static_cast<double>(cameras.size()));
                }));
    RequireUsable("camera " + name, arguments, rig.cameras.back(), pattern);
  }
  return rig;
}

RigMeasurements Gather(const CalibrateArguments& arguments,
                       const CommonOptions& common,
                       const FeaturesByCamera& given, const Pattern& pattern,
                       ProgressBar* bar) {
  RigMeasurements rig = given.empty()
                            ? MeasureAll(arguments, common, pattern, bar)
                            : GivenFeatures(arguments, given, pattern);
  if (arguments.instant_by == "number")
    for (size_t c = 0; c < rig.names.size(); ++c)
      NameImagesByNumber("camera " + rig.names[c], &rig.cameras[c].dataset);
  return rig;
}

// The cameras of a rig with the checkpoints of an interrupted calibration, if
// there are any.
std::vector<CalibrationInput> CamerasOf(const RigMeasurements& rig,
                                        const CalibrateArguments& arguments,
                                        int num_threads,
                                        CheckpointFile* checkpoints) {
  std::vector<CalibrationInput> cameras;
  for (size_t c = 0; c < rig.names.size(); ++c) {
    cameras.push_back(
        {rig.names[c], rig.cameras[c].dataset,
         AgainIn(rig.cameras[c], arguments, num_threads), checkpoints->Of(c),
         [=](const Checkpoint& done) { checkpoints->Keep(c, done); },
         rig.cameras[c].skipped});
  }
  return cameras;
}

// ---- Output ----------------------------------------------------------------

void AddFiles(const RigResult& result, const std::vector<PackedCamera>& packed,
              const std::vector<Thumbnails>& thumbnails, uint64_t seed,
              const std::string& folder, OutputFiles* files) {
  ResultExtras extras = {seed, PeakMemoryBytes(), {}};
  for (size_t c = 0; c < result.cameras.size(); ++c) {
    extras.cameras.push_back({packed[c].blob, {}, {}, thumbnails[c]});
    if (!result.cameras[c].checkpoint)
      extras.cameras.back().packing = FiguresOf(packed[c]);
  }
  AddResultFiles(result, extras, folder, files);
}

std::string WithDeviation(double value, const std::optional<double>& deviation,
                          double scale, const char* unit) {
  return deviation ? fmt::format("{:.4f} +- {:.4f} {}", value * scale,
                                 *deviation * scale, unit)
                   : fmt::format("{:.4f} {}", value * scale, unit);
}

void PrintSummary(const CalibrateArguments& arguments,
                  const RigResult& result) {
  for (const CalibrationResult& camera : result.cameras) {
    fmt::print("{}: {}, {} parameters, {} images", camera.camera.name,
               camera.camera.camera->Name(), camera.num_parameters,
               camera.features.images.size());
    if (camera.cell_px > 0) fmt::print(", cells of {:.0f} px", camera.cell_px);
    fmt::print("\n");
    PrintTraining(camera);
    if (camera.camera.held_out)
      PrintFigures("held out", *camera.camera.held_out);
  }
  fmt::print("rig\n");
  PrintFigures("training", TrainingFigures(result));
  if (const auto held_out = HeldOutFigures(result))
    PrintFigures("held out", *held_out);
  for (const Baseline& baseline : result.baselines)
    fmt::print(
        "  {} to {}: {}, {}, {} common views\n",
        result.cameras[baseline.first].camera.name,
        result.cameras[baseline.second].camera.name,
        WithDeviation(baseline.distance_m, baseline.distance_sd_m, 1000, "mm"),
        WithDeviation(baseline.angle_rad, baseline.rotation_sd_rad, 180 / M_PI,
                      "degrees"),
        baseline.num_shared_views);
  fmt::print("  verdict: {}\n", result.verdict.word);
  for (const std::string& reason : result.verdict.reasons)
    fmt::print("    {}\n", Printable(reason));
  fmt::print("  results in {}\n", Printable(arguments.output));
}

// The checkpoints of all cameras, or none.
std::vector<Checkpoint> CheckpointsOf(const RigResult& result) {
  std::vector<Checkpoint> checkpoints;
  for (const CalibrationResult& camera : result.cameras)
    if (camera.checkpoint) checkpoints.push_back(*camera.checkpoint);
  return checkpoints;
}

void RequireNothingForOneCamera(const CalibrateArguments& arguments) {
  if (!arguments.name.empty() || !arguments.serial.empty())
    throw Error(ExitCode::kUsage,
                "--name and --serial are for a single camera; a rig's names "
                "are those of --camera, and pack --serial gives a blob its "
                "serial number");
}

}  // namespace

void RunRig(const CalibrateArguments& arguments, const CommonOptions& common,
            const FeaturesByCamera& given) {
  RequireNothingForOneCamera(arguments);
  const Pattern pattern = MeantPattern(arguments.pattern, common);
  RequireNoInputReplaced(arguments, {});
  RequireWritableFolder(arguments.output);
  std::string inputs;
  RigResult result;
  std::vector<PackedCamera> packed;
  std::vector<Thumbnails> thumbnails;
  {
    ProgressBar bar(common.quiet);
    const CalibrationOptions options = OptionsOf(arguments, common, &bar);
    const RigMeasurements rig = Gather(arguments, common, given, pattern, &bar);
    inputs = InputsOf(arguments, common, rig.cameras, pattern);
    CheckpointFile checkpoints(arguments.output, inputs, rig.cameras.size());
    if (arguments.resume) checkpoints.Read();
    NoteInterruptions();
    result = Calibrate(CamerasOf(rig, arguments, common.threads, &checkpoints),
                       pattern, options);
    bar.Show("packing", 0.9);
    FinishUndisturbed();
    for (size_t c = 0; c < rig.cameras.size(); ++c)
      AddLeftOut(rig.cameras[c], &result.cameras[c]);
    for (const CalibrationResult& camera : result.cameras)
      packed.push_back(
          camera.checkpoint
              ? PackedCamera()
              : PackWhatCanBe(camera.camera, common.threads, IsInterrupted));
    for (const Measurements& camera : rig.cameras)
      thumbnails.push_back(
          MakeThumbnails(camera.dataset, camera.paths, common.threads));
  }
  const std::vector<Checkpoint> checkpoints = CheckpointsOf(result);
  KeepFinishedResult(arguments.output, checkpoints, inputs);
  OutputFolder output(arguments.output);
  OutputFiles files;
  AddFiles(result, packed, thumbnails, common.seed, output.path(), &files);
  if (!checkpoints.empty())
    files.Add(output.path() + "/resume.json",
              FormatCheckpoints(checkpoints, inputs));
  files.Commit();
  AddReports(output.path(), &files);
  files.Commit();
  output.Commit(ResultFiles(arguments.output));
  if (common.json)
    fmt::print(
        "{}", ReadFile((std::filesystem::path(arguments.output) / "result.json")
                           .string()));
  else if (!common.quiet)
    PrintSummary(arguments, result);
  if (!common.quiet)
    for (size_t c = 0; c < packed.size(); ++c)
      PrintRemarks(result.cameras[c].camera.name + "/camera.raygrid",
                   packed[c]);
  RequireSuccess(result.verdict, !checkpoints.empty(), arguments.output);
}

}  // namespace raygrid
