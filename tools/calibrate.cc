#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <set>

#include "calibration_input.h"
#include "calibration_summary.h"
#include "capture_metadata.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/image_files.h"
#include "dataset/output_folder.h"
#include "help_formatter.h"
#include "interruption.h"
#include "operating_point_input.h"
#include "packing/blob_camera.h"
#include "packing/pack.h"
#include "pattern_input.h"
#include "report/checkpoint_json.h"
#include "report/plots.h"
#include "report/result_folder.h"
#include "session_file.h"
#include "stereo_example.h"
#include "view_options.h"

namespace raygrid {
namespace {

void RequireSingleCameraOptions(const CalibrateArguments& arguments,
                                bool is_rig) {
  if (is_rig && arguments.image_circle != "auto" &&
      arguments.image_circle != "none")
    throw Error(ExitCode::kUsage,
                fmt::format("--image-circle {}: the cameras of a rig have "
                            "different image circles; use auto or none",
                            arguments.image_circle));
  if (is_rig && !(arguments.name.empty() && arguments.serial.empty()))
    throw Error(
        ExitCode::kUsage,
        "--name and --serial are for a single camera; for a rig, name cameras "
        "with --camera and set serial numbers with pack --serial");
  RequireBlobText("--name", arguments.name);
  RequireBlobText("--serial", arguments.serial);
}

// Sets the blob's operating point to that of an image.
void SetOperatingPointOfImage(const ImageOperatingPoints& conditions,
                              const std::string& image, BlobCamera* camera) {
  const auto range = camera->Range();
  if (!range) return;
  for (size_t k = 0; k < conditions.conditions.size(); ++k)
    if (conditions.conditions[k] == range->condition)
      camera->SetOperatingPoint(conditions.values.at(image)[k]);
}

// Returns a comparison before/after undistortion: of the first held-out image,
// otherwise of the first training image, downscaled.
std::optional<BeforeAfter> ExampleImage(const Measurements& measurements,
                                        const CalibrationResult& result,
                                        const CalibrateArguments& arguments,
                                        const CaptureMetadata& capture_metadata,
                                        const std::string& blob) {
  constexpr int kMaxWidthPx = 800;
  const std::string& wanted = arguments.hold_out.empty()
                                  ? result.features.images.front().image
                                  : arguments.hold_out.front();
  const auto& conditions = capture_metadata.conditions;
  for (size_t i = 0; i < measurements.paths.size(); ++i) {
    if (measurements.dataset.images[i].image != wanted) continue;
    const Image before = ReadImage(measurements.paths[i], true);
    BlobCamera camera("packed camera", blob);
    if (conditions) SetOperatingPointOfImage(*conditions, wanted, &camera);
    const Image after = camera.Undistort(before, 0);
    return BeforeAfter{ShrinkImage(before, kMaxWidthPx),
                       ShrinkImage(after, kMaxWidthPx)};
  }
  return std::nullopt;
}

// Removes near-duplicate images, which are not drawn.
void ExcludeNearDuplicates(const CalibrationResult& result,
                           Measurements* part) {
  std::set<std::string> others;
  for (const NearDuplicates& group : result.near_duplicates)
    others.insert(group.others.begin(), group.others.end());
  Measurements kept = *part;
  kept.dataset.images.clear();
  kept.paths.clear();
  for (size_t i = 0; i < part->paths.size(); ++i) {
    if (others.count(part->dataset.images[i].image) > 0) continue;
    kept.dataset.images.push_back(part->dataset.images[i]);
    kept.paths.push_back(part->paths[i]);
  }
  *part = std::move(kept);
}

// Removes images of other sensor modes: the pictures drawn over images use
// calibrated pixel coordinates.
Measurements CropToCalibrated(const Measurements& all) {
  Measurements part = all;
  part.dataset.images.resize(NumCalibratedImages(all));
  part.paths.resize(std::min(all.paths.size(), part.dataset.images.size()));
  part.modes.clear();
  return part;
}

int64_t PeakMemoryBytes() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<int64_t>(usage.ru_maxrss) * 1024;
}

// Returns the blobs of the cameras and the pictures of their images.
// Interrupted calibrations, and those distorted by an uncompensated rolling
// shutter, are not packed.
ResultExtras MakeExtras(const std::vector<Measurements>& cameras,
                        const RigResult& result,
                        const CalibrateArguments& arguments,
                        const CaptureMetadata& capture_metadata,
                        const CommonOptions& common) {
  ResultExtras extras = {common.seed, PeakMemoryBytes(), {}};
  for (size_t c = 0; c < cameras.size(); ++c) {
    const CalibrationResult& camera = result.cameras[c];
    CameraExtras& own = extras.cameras.emplace_back();
    Measurements calibrated = CropToCalibrated(cameras[c]);
    ExcludeNearDuplicates(camera, &calibrated);
    if (result.IsRig() || !camera.checkpoint)
      own.thumbnails =
          MakeThumbnails(calibrated.dataset, calibrated.paths, common.threads);
    const bool has_wrong_times =
        camera.line_delay && !camera.line_delay->are_timestamps_consistent;
    if (camera.checkpoint || has_wrong_times) continue;
    const PackedCamera packed =
        PackSupportedSections(camera.camera, common.threads, IsInterrupted);
    own.packing = ComputePackingMetrics(packed);
    if (!result.IsRig() && !packed.remaps.empty())
      own.example = ExampleImage(calibrated, camera, arguments,
                                 capture_metadata, packed.blob);
    own.blob = packed.blob;
    if (!packed.remaps.empty())
      own.view = ViewCameraFile(packed.remaps[0].view, camera.camera.name);
  }
  if (result.IsRig() && !IsInterrupted())
    extras.stereo = MakeStereoExample(cameras, result, common.threads);
  return extras;
}

// Frames recorded at several lens positions have different intrinsics.
void WarnAboutFocusMotion(const Session& session,
                          const CalibrateArguments& arguments) {
  constexpr double kMaxDioptreDifference = 0.1;
  double low = INFINITY, high = -INFINITY;
  for (const SessionFrame& frame : session.frames) {
    if (!frame.lens_position) continue;
    low = std::min(low, *frame.lens_position);
    high = std::max(high, *frame.lens_position);
  }
  if (arguments.condition.empty() && high - low > kMaxDioptreDifference)
    fmt::print(stderr,
               "raygrid: focus changed between frames, from {:.2f} to {:.2f} "
               "dioptres; use --vary-with lens_position to model this\n",
               low, high);
}

// Reads images, pattern and output folder from a capture session, if one is
// given; explicit options override the last two.
void UseSession(CalibrateArguments* arguments) {
  if (arguments->images.size() == 1 && IsSession(arguments->images[0])) {
    const std::filesystem::path folder = arguments->images[0];
    const std::vector<Session> cameras = ReadSession(folder.string());
    arguments->images.clear();
    for (const Session& session : cameras) {
      if (session.frames.empty())
        throw Error(ExitCode::kInsufficientData,
                    fmt::format("{}: {}no frame was kept; continue the session "
                                "with raygrid capture --resume",
                                folder.string(),
                                session.camera.empty()
                                    ? ""
                                    : "camera " + session.camera + " "));
      arguments->captures.push_back(GetCaptureSettings(session));
      arguments->session_times.push_back(CollectTimes(session));
      // If deletion was interrupted, the file of a deleted frame may still
      // exist.
      std::vector<std::string> images;
      for (const SessionFrame& frame : session.frames) {
        images.push_back(
            SessionFramePath(folder.string(), session.camera, frame.image));
        if (const auto values = GetOperatingPoint(*arguments, frame))
          arguments->session_values[frame.image] = *values;
      }
      WarnAboutFocusMotion(session, *arguments);
      if (cameras.size() == 1)
        arguments->images = images;
      else
        arguments->rig.push_back({session.camera, images});
    }
    if (arguments->pattern.empty())
      arguments->pattern = (folder / kSessionPattern).string();
    if (arguments->output.empty())
      arguments->output = (folder / "calibration").string();
  }
}

// Reads the images and their times from bags, if any are given.
void UseBags(bool quiet, CalibrateArguments* arguments) {
  if (arguments->cameras.empty()) {
    BagFrames frames;
    arguments->images =
        ExpandBags(arguments->images, arguments->bags, quiet, &frames);
    if (!frames.empty())
      arguments->session_times.push_back(MakeImageTimes(frames));
    return;
  }
  const std::vector<RigCameraImages> rig = ExpandRigBags(
      ParseCameraValues("--camera", "FOLDER", arguments->cameras),
      arguments->bags, arguments->sync_by, quiet, &arguments->session_times);
  if (rig.empty()) return;
  arguments->rig = rig;
  arguments->cameras.clear();
}

void RequirePatternAndOutput(const CalibrateArguments& arguments) {
  for (const auto& [option, value] :
       {std::pair("--pattern", &arguments.pattern),
        std::pair("--output", &arguments.output)})
    if (value->empty())
      throw Error(ExitCode::kUsage,
                  fmt::format("{} is required, except for a capture session; "
                              "see raygrid calibrate --help",
                              option));
}

// Adds data that the optimization does not use: serial numbers, the capture
// settings of a session, and files that are not photographs, which the
// assessment ignores.
void CompleteResult(const std::vector<Measurements>& cameras,
                    const CalibrateArguments& arguments, RigResult* result) {
  for (size_t c = 0; c < cameras.size(); ++c) {
    const std::vector<RejectedImage>& left_out = cameras[c].left_out;
    CalibrationResult& camera = result->cameras[c];
    camera.rejected_images.insert(camera.rejected_images.end(),
                                  left_out.begin(), left_out.end());
    if (camera.has_known_intrinsics) continue;
    camera.camera.serial = arguments.serial;
    if (c < arguments.captures.size() && arguments.captures[c].HasAny())
      camera.camera.capture = arguments.captures[c];
  }
}

// Returns the checkpoints of all cameras; empty if one is missing.
std::vector<Checkpoint> GetCheckpoints(const RigResult& result) {
  std::vector<Checkpoint> checkpoints;
  for (const CalibrationResult& camera : result.cameras)
    if (camera.checkpoint) checkpoints.push_back(*camera.checkpoint);
  return checkpoints;
}

// Replaces an earlier result in the folder. resume is the text of resume.json,
// or empty.
void WriteResult(const RigResult& result, const ResultExtras& extras,
                 const std::string& resume, const std::string& folder) {
  OutputFolder output(folder);
  OutputFiles files;
  AddResultFiles(result, extras, output.path(), &files);
  if (!resume.empty()) files.Add(output.path() + "/resume.json", resume);
  files.Commit();
  AddReports(output.path(), &files);
  files.Commit();
  output.Commit(ResultFiles(folder));
}

// Prints the warnings of packing on standard error.
void PrintWarnings(const RigResult& result, const ResultExtras& extras) {
  for (size_t c = 0; c < extras.cameras.size(); ++c)
    if (const auto& packing = extras.cameras[c].packing)
      for (const std::string& warning : packing->warnings)
        fmt::print(stderr, "raygrid: {}camera.raygrid: {}\n",
                   CameraFolder(result, c), warning);
}

// Throws the error that corresponds to the exit code, after all files of the
// calibration have been written.
void RequireSuccess(const Assessment& assessment, bool is_interrupted,
                    const std::string& folder) {
  if (is_interrupted)
    throw Error(ExitCode::kNotConverged,
                fmt::format("interrupted; {} contains the best state so far; "
                            "continue with --resume",
                            folder));
  if (assessment.word == "fail")
    throw Error(ExitCode::kQualityTooLow,
                fmt::format("verdict: fail: {}; do not use the camera in {} "
                            "until this is fixed",
                            assessment.failure, folder));
}

// Throws if a blob could not be created: the calibration is then not a success.
void RequireBlobs(const RigResult& result, const ResultExtras& extras,
                  const std::string& folder) {
  for (size_t c = 0; c < extras.cameras.size(); ++c)
    if (extras.cameras[c].packing && extras.cameras[c].blob.empty())
      throw Error(
          ExitCode::kQualityTooLow,
          fmt::format("{}/{}camera.raygrid {}; all other files were written",
                      folder, CameraFolder(result, c),
                      fmt::join(extras.cameras[c].packing->warnings, "; ")));
}

void Run(const CalibrateArguments& arguments, const CommonOptions& common) {
  const FeaturesByCamera given = ReadFeatureInputs(arguments);
  const bool is_rig = given.size() > 1 || arguments.HasCameraImages();
  RequireSingleCameraOptions(arguments, is_rig);
  RequireOperatingPointOptions(arguments, is_rig);
  const IntrinsicsByCamera intrinsics = ReadKnownIntrinsics(arguments, given);
  const Pattern pattern = LoadCheckedPattern(arguments.pattern, common);
  RequireNoInputReplaced(arguments, FindImages(arguments.images).paths);
  RequireCreatableFolder(arguments.output);

  std::string inputs;
  std::vector<std::string> warnings;
  RigResult result;
  ResultExtras extras;
  {
    ProgressBar bar(common.quiet);
    const CalibrationOptions options =
        MakeCalibrationOptions(arguments, common, &bar);
    const std::vector<Measurements> cameras =
        CollectMeasurements(arguments, common, given, pattern, &bar);
    const CaptureMetadata capture_metadata =
        ReadCaptureMetadata(arguments, cameras);
    inputs = SerializeInputs(arguments, common, cameras, capture_metadata,
                             intrinsics, pattern);
    CheckpointFile checkpoints(arguments.output, inputs, cameras.size());
    if (arguments.resume) checkpoints.Read();
    InstallInterruptHandler();
    const std::vector<CalibrationInput> calibration_inputs =
        MakeCalibrationInputs(cameras, capture_metadata, arguments, intrinsics,
                              common.threads, &checkpoints);
    const auto& conditions = capture_metadata.conditions;
    if (conditions)
      warnings = {
          WarnAboutUnmatchedRows(arguments, *conditions, cameras.front()),
          WarnAboutUnits(*conditions)};
    result = conditions
                 ? CalibrateOperatingPoints(calibration_inputs.front(),
                                            *conditions, pattern, options)
                 : Calibrate(calibration_inputs, pattern, options);
    IgnoreFirstSignal();
    CompleteResult(cameras, arguments, &result);
    bar.Show("packing", 0.9);
    extras = MakeExtras(cameras, result, arguments, capture_metadata, common);
    for (size_t c = 0; c < cameras.size(); ++c)
      if (const auto known = intrinsics.find(cameras[c].camera);
          known != intrinsics.end())
        extras.cameras[c].camera_yaml = known->second.yaml;
  }
  const std::vector<Checkpoint> checkpoints = GetCheckpoints(result);
  PreserveFinishedResult(arguments.output, checkpoints, inputs);
  WriteResult(result, extras,
              checkpoints.empty() ? "" : FormatCheckpoints(checkpoints, inputs),
              arguments.output);

  const std::filesystem::path folder = arguments.output;
  if (common.json)
    fmt::print("{}", ReadFile((folder / "result.json").string()));
  else if (!common.quiet)
    PrintSummary(result, arguments.output);
  if (!common.quiet) PrintWarnings(result, extras);
  for (const std::string& warning : warnings)
    if (!common.quiet && !warning.empty())
      fmt::print(stderr, "raygrid: {}\n", warning);
  RequireSuccess(result.assessment, !checkpoints.empty(), arguments.output);
  RequireBlobs(result, extras, arguments.output);
}

void AddCalibrationInputs(CLI::App* command, CalibrateArguments* arguments) {
  command->add_option("images", arguments->images,
                      "images, folders, a capture session or bags");
  AddRigImageOptions(command, &arguments->cameras, &arguments->sync_by,
                     &arguments->features);
  command
      ->add_option(
          "--image-size", arguments->image_sizes,
          "image size in px, with --features; NAME=WxH for one camera of a rig")
      ->option_text("WxH")
      ->allow_extra_args(false);
  AddHoldOut(command,
             "test images (rig: frames), excluded from calibration (default: "
             "cross-validation)",
             &arguments->hold_out);
  command
      ->add_option(
          "--duplicate-px", arguments->duplicate_px,
          "skip images whose features moved by less than this since a kept "
          "image; 0: keep all; auto: 0.1 % of the longer side, at least 1")
      ->option_text("PX")
      ->capture_default_str();
  command
      ->add_option("--mode", arguments->modes,
                   "sensor mode of the images in a folder: crop=X,Y,W,H bin=N "
                   "scale=S size=WxH flip=h|v|hv rotate=180")
      ->option_text("DIR:KEY=VALUE,...")
      ->allow_extra_args(false);
  AddBagOptions(command, &arguments->bags, true);
}

void AddModelOptions(CLI::App* command, CalibrateArguments* arguments) {
  BeginGroup(command, help_group::kModel);
  AddIntrinsicsOption(command, &arguments->intrinsics);
  command
      ->add_option("--model", arguments->model,
                   fmt::format("{}, or auto: chosen by cross-validation",
                               fmt::join(ListCalibratedModels(), ", ")))
      ->option_text("NAME")
      ->capture_default_str();
  command->add_flag("--allow-noncentral", arguments->allow_noncentral,
                    "allow auto to choose noncentral-generic, which can be "
                    "undistorted for one distance only");
  command
      ->add_option("--knot-spacing-px", arguments->knot_spacing_px,
                   "maximum knot spacing of the B-spline grid; auto: chosen by "
                   "cross-validation")
      ->option_text("PX")
      ->capture_default_str();
  command
      ->add_option("--area", arguments->area,
                   "calibrated area: the whole image (extrapolated beyond the "
                   "features), or the bounding box of the features")
      ->check(CLI::IsMember({"image", "features"}))
      ->option_text("image|features")
      ->capture_default_str();
  command
      ->add_option("--image-circle", arguments->image_circle,
                   "image circle of a fisheye, outside of which the camera is "
                   "not calibrated: auto (detected), none, or X,Y,RADIUS in px")
      ->option_text("CIRCLE")
      ->capture_default_str();
  command
      ->add_option("--prior", arguments->like,
                   "camera.yaml of a similar camera, or fleet_camera.yaml, "
                   "used as a prior of the central-generic grid")
      ->option_text("FILE");
  command->add_flag("--rolling-shutter", arguments->rolling_shutter,
                    "estimate the line delay from consecutive frames and "
                    "compensate for it");
  command
      ->add_option("--timestamps", arguments->times,
                   "with --rolling-shutter: CSV image,time_s (default: "
                   "timestamps of the session or bag)")
      ->option_text("FILE");
  AddOperatingPointOptions(command, arguments);
}

}  // namespace

void AddCalibrate(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "calibrate", "Calibrate a camera or a rig from images of a target.",
      "raygrid calibrate photos/ --pattern pattern.yaml -o result/", common);
  auto arguments = std::make_shared<CalibrateArguments>();
  AddCalibrationInputs(command, arguments.get());
  AddModelOptions(command, arguments.get());
  AddPatternOption(command, &arguments->pattern,
                   "; not needed for a capture session");
  AddYesOption(command, common);
  BeginGroup(command, help_group::kTarget);
  command->add_flag(
      "--fix-target-geometry", arguments->fix_target_geometry,
      "do not estimate the target geometry; use the nominal points");
  command->add_flag("--rigid-target", arguments->rigid_board,
                    "do not estimate per-view target deformation");
  command->add_flag("--independent-boards", arguments->independent_boards,
                    "estimate a pose per board (default: one pose for boards "
                    "detected as rigidly connected)");
  BeginGroup(command, help_group::kOutput);
  command
      ->add_option("-o,--output", arguments->output,
                   "output folder (default for a session: calibration/ in the "
                   "session folder)")
      ->option_text("DIR");
  command->add_option("--name", arguments->name, "camera name")
      ->option_text("NAME");
  command->add_option("--serial", arguments->serial, "camera serial number")
      ->option_text("SERIAL");
  command->add_flag(
      "--skip-comparison", arguments->skip_comparison,
      "do not calibrate parametric models for the comparison in the report");
  command
      ->add_option("--valid-px", arguments->valid_px,
                   "limit of the valid region: predicted uncertainty in px, 1 "
                   "sigma; auto: 0.25, or 3 times the feature noise if larger")
      ->option_text("PX")
      ->capture_default_str();
  BeginGroup(command, help_group::kAdvanced);
  command->add_flag("--no-refine-features", arguments->measure_once,
                    "do not refine features with the estimated camera");
  command->add_flag("--resume", arguments->resume,
                    "continue an interrupted calibration with the same input, "
                    "options and output folder");
  AddHugeOption(command);
  command->callback([arguments, common] {
    UseSession(arguments.get());
    RequirePatternAndOutput(*arguments);
    UseBags(common->quiet, arguments.get());
    Run(*arguments, *common);
  });
}

}  // namespace raygrid
