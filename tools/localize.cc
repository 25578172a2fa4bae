#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "calibration/rigid_targets.h"
#include "calibration/target_localization.h"
#include "calibration_input.h"
#include "camera_values.h"
#include "commands.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/output_folder.h"
#include "dataset/text_encoding.h"
#include "fixed_rig.h"
#include "help_formatter.h"
#include "json_output.h"
#include "pattern_input.h"
#include "report/pose_sheet.h"
#include "report/residual_file.h"
#include "report/result_fields.h"

namespace raygrid {
namespace {

struct LocalizeArguments {
  std::string camera, features, pattern, output, sync_by = "name";
  std::vector<std::string> images, folders;
  std::vector<RigCameraImages> rig;  // images of each of the folders
  BagOptions bags;
  bool independent_boards = false, estimate_target = false;
};

constexpr const char* kPosesImage = "poses.png";
constexpr const char* kEstimatedPattern = "estimated_pattern.yaml";
constexpr const char* kLocalizationFiles[] = {kEstimatedPattern, "poses.csv",
                                              kPosesImage, "residuals.csv"};

// The detections in the images of a camera.
struct CameraImages {
  Dataset dataset;
  std::vector<std::string> paths;  // image paths; may be empty
  std::vector<RejectedImage> skipped;
};

// ---- Input -----------------------------------------------------------------

void RequireOneSource(const LocalizeArguments& arguments) {
  if (!arguments.images.empty() + !arguments.folders.empty() +
          !arguments.features.empty() !=
      1)
    throw Error(ExitCode::kUsage,
                "localize: specify exactly one of images, --camera (for a rig) "
                "and --features");
}

CameraImages DetectTargets(const std::vector<std::string>& images,
                           const std::string& name, const CameraInput& camera,
                           const Pattern& pattern,
                           const LocalizeArguments& arguments,
                           const CommonOptions& common) {
  Measurements detected =
      DetectAll(images, pattern, arguments.pattern, common, {});
  CameraImages result = {std::move(detected.dataset), std::move(detected.paths),
                         std::move(detected.skipped)};
  result.skipped.insert(result.skipped.end(), detected.left_out.begin(),
                        detected.left_out.end());
  const ImageSize& size = camera.file.camera->image_size();
  const ImageSize& found = result.dataset.image_size;
  if (found != size && result.dataset.num_features() > 0)
    throw InputError(fmt::format(
        "{}the images have {} x {} pixels, the camera {} x {}; use images of "
        "the calibrated sensor mode",
        name.empty() ? "" : "camera " + name + ": ", found.width, found.height,
        size.width, size.height));
  UseRuntimeRays(camera, &result.dataset);
  return result;
}

// Reads the images of bags, if any are given.
void UseBags(bool quiet, LocalizeArguments* arguments) {
  if (arguments->folders.empty()) {
    arguments->images = ExpandBags(arguments->images, arguments->bags, quiet);
    return;
  }
  const std::vector<NamedValue> folders =
      ParseCameraValues("--camera", "DIR", arguments->folders);
  arguments->rig =
      ExpandRigBags(folders, arguments->bags, arguments->sync_by, quiet);
  if (!arguments->rig.empty()) return;
  RequireSeparateFolderNames("--camera", folders);
  for (const auto& [name, folder] : folders)
    arguments->rig.push_back({name, {folder}});
}

std::vector<CameraImages> DetectInRig(const FixedRig& rig,
                                      const Pattern& pattern,
                                      const LocalizeArguments& arguments,
                                      const CommonOptions& common) {
  std::vector<CameraImages> cameras(rig.names.size());
  for (const auto& [name, images] : arguments.rig) {
    const auto found = std::find(rig.names.begin(), rig.names.end(), name);
    if (found == rig.names.end())
      throw Error(ExitCode::kUsage,
                  fmt::format("--camera {}: {} has no camera '{}'", name,
                              arguments.camera, name));
    const auto c = found - rig.names.begin();
    cameras[c] =
        DetectTargets(images, name, rig.cameras[c], pattern, arguments, common);
  }
  for (size_t c = 0; c < cameras.size(); ++c)
    cameras[c].dataset.image_size = rig.model.cameras[c]->image_size();
  return cameras;
}

std::vector<CameraImages> GatherFeatures(const FixedRig& rig,
                                         const Pattern& pattern,
                                         const LocalizeArguments& arguments,
                                         const CommonOptions& common) {
  std::vector<CameraImages> cameras;
  if (!arguments.features.empty()) {
    for (Dataset& dataset : ReadRigFeatures(rig, arguments.features, pattern))
      cameras.push_back({std::move(dataset), {}, {}});
  } else if (rig.is_rig) {
    if (arguments.rig.empty())
      throw Error(ExitCode::kUsage,
                  fmt::format("{}: is a rig; specify the images of each camera "
                              "with --camera NAME=DIR",
                              arguments.camera));
    cameras = DetectInRig(rig, pattern, arguments, common);
  } else {
    if (!arguments.folders.empty())
      throw Error(ExitCode::kUsage,
                  fmt::format("--camera is for a rig, but {} is a camera; "
                              "specify its images without an option",
                              arguments.camera));
    cameras.push_back(DetectTargets(arguments.images, "", rig.cameras[0],
                                    pattern, arguments, common));
  }
  if (rig.is_rig && arguments.sync_by == "number")
    for (size_t c = 0; c < cameras.size(); ++c)
      RenameImagesByNumber("camera " + rig.names[c], &cameras[c].dataset);
  size_t num_features = 0;
  for (const CameraImages& camera : cameras)
    num_features += camera.dataset.num_features();
  if (num_features == 0)
    throw Error(ExitCode::kInsufficientData, "no target found in the images");
  return cameras;
}

// ---- Output ----------------------------------------------------------------

// Formats the residuals as held-out residuals, since the camera was not
// calibrated from these images.
std::string FormatHeldOutResiduals(const FixedRig& rig,
                                   const TargetLocalization& localization) {
  RigResult result;
  for (size_t c = 0; c < rig.names.size(); ++c) {
    CalibrationResult& camera = result.cameras.emplace_back();
    camera.camera.name = rig.names[c];
    camera.held_out = localization.cameras[c].residuals;
  }
  return FormatResiduals(result);
}

// Returns an image with the poses of its boards, from the targets localized in
// its frame.
LocalizedImage MakeLocalizedImage(const FixedRig& rig, const RigModel& model,
                                  size_t camera, const CameraImages& images,
                                  size_t index, const Pattern& pattern,
                                  const TargetLocalization& localization) {
  const ImageFeatures& features = images.dataset.images[index];
  LocalizedImage image;
  image.title = rig.names[camera].empty()
                    ? Printable(features.image)
                    : rig.names[camera] + ": " + Printable(features.image);
  image.camera = model.cameras[camera];
  for (const TargetPose& target : localization.poses) {
    if (target.pose.image != features.image) continue;
    image.boards.push_back(pattern.FindBoard(target.pose.board));
    image.camera_from_board.push_back(model.camera_from_rig[camera] *
                                      target.pose.camera_from_board);
    image.caption +=
        fmt::format("{}board {}: {:.3g} px, sd {:.2g}°, {:.2g} mm",
                    image.caption.empty() ? "" : "; ", target.pose.board,
                    target.rms_px, target.RotationStdDev() * 180 / M_PI,
                    1000 * target.TranslationStdDev());
  }
  if (!image.boards.empty())
    image.picture = ReadImage(images.paths[index], true);
  return image;
}

// Returns a few evenly spaced images of each camera with projected axes; empty
// without images.
std::string EncodePoseSheet(const FixedRig& rig, const RigModel& model,
                            const std::vector<CameraImages>& cameras,
                            const Pattern& pattern,
                            const TargetLocalization& localization) {
  constexpr size_t kMaxImages = 8;
  std::vector<LocalizedImage> images;
  const size_t per_camera = std::max(kMaxImages / cameras.size(), size_t{1});
  for (size_t c = 0; c < cameras.size(); ++c) {
    const size_t count = cameras[c].paths.size();
    for (size_t k = 0; k < std::min(count, per_camera); ++k) {
      LocalizedImage image = MakeLocalizedImage(
          rig, model, c, cameras[c], k * count / std::min(count, per_camera),
          pattern, localization);
      if (!image.boards.empty()) images.push_back(std::move(image));
    }
  }
  return images.empty() ? "" : EncodePng(PoseSheet(std::move(images)));
}

double ComputeMedian(const std::vector<TargetPose>& poses,
                     double (TargetPose::*std_dev)() const) {
  std::vector<double> values;
  for (const TargetPose& pose : poses) values.push_back((pose.*std_dev)());
  return Quantile(std::move(values), 0.5);
}

// Returns the RMS distance of the points from those of another pattern, in
// metres.
double RmsDifference(const Pattern& pattern, const Pattern& other) {
  double sum = 0;
  size_t count = 0;
  for (size_t b = 0; b < pattern.boards.size(); ++b)
    for (size_t i = 0; i < pattern.boards[b].points.size(); ++i, ++count)
      sum += (pattern.boards[b].points[i] - other.boards[b].points[i])
                 .squaredNorm();
  return std::sqrt(sum / static_cast<double>(std::max<size_t>(count, 1)));
}

// The printed summary of a localization.
struct LocalizationSummary {
  ErrorMetrics errors;
  int num_frames = 0, outside_area = 0;
  double rotation_stddev_rad = 0, translation_stddev_m = 0;
  std::vector<std::optional<double>> systematic_px;  // of each camera
  std::optional<double> target_change_m;             // RMS
  std::vector<std::string> files;
};

LocalizationSummary Summarize(const RigModel& model,
                              const TargetLocalization& localization) {
  LocalizationSummary summary;
  std::vector<FeatureResidual> residuals;
  for (size_t c = 0; c < localization.cameras.size(); ++c) {
    const Evaluation& camera = localization.cameras[c];
    summary.systematic_px.push_back(
        ComputeSystematicError(camera.residuals, model.cameras[c]->area()));
    residuals.insert(residuals.end(), camera.residuals.begin(),
                     camera.residuals.end());
    summary.outside_area += camera.outside_area;
  }
  summary.errors = ComputeErrorMetrics(residuals);
  std::set<std::string> frames;
  for (const TargetPose& target : localization.poses)
    frames.insert(target.pose.image);
  summary.num_frames = static_cast<int>(frames.size());
  summary.rotation_stddev_rad =
      ComputeMedian(localization.poses, &TargetPose::RotationStdDev);
  summary.translation_stddev_m =
      ComputeMedian(localization.poses, &TargetPose::TranslationStdDev);
  return summary;
}

// Says that the intrinsics are wrong where much of the error is systematic.
void WarnAboutIntrinsics(const std::string& name,
                         const std::vector<FeatureResidual>& residuals,
                         const std::optional<double>& systematic_px) {
  constexpr double kMinShare = 0.5;  // of the RMS error
  constexpr double kMinPx = 0.02;
  const double rms_px = ComputeErrorMetrics(residuals).rms_px;
  if (!systematic_px || *systematic_px < kMinPx ||
      *systematic_px < kMinShare * rms_px)
    return;
  fmt::print(stderr,
             "raygrid: {}warning: {:.2g} of {:.2g} px RMS reprojection error "
             "repeat in all images: the intrinsics do not fit these images; "
             "calibrate the camera again\n",
             name.empty() ? "" : name + ": ", *systematic_px, rms_px);
}

nlohmann::ordered_json ToJson(const Evaluation& evaluation) {
  nlohmann::ordered_json json = ComputeErrorMetrics(evaluation.residuals);
  json["outside_area_features"] = evaluation.outside_area;
  json["rejected_images"] = RejectedImagesJson(evaluation.rejected_images);
  return json;
}

nlohmann::ordered_json ToJson(const FixedRig& rig, const Pattern& pattern,
                              const TargetLocalization& localization,
                              const LocalizationSummary& summary) {
  nlohmann::ordered_json json = {{"num_poses", localization.poses.size()},
                                 {"num_frames", summary.num_frames}};
  json.update(nlohmann::ordered_json(summary.errors));
  json["noise_px"] = localization.noise_px;
  json["rotation_sd_rad"] = summary.rotation_stddev_rad;
  json["translation_sd_m"] = summary.translation_stddev_m;
  json["outside_area_features"] = summary.outside_area;
  if (summary.target_change_m)
    json["target_change_m"] = *summary.target_change_m;
  json["rigid_targets"] = MakeRigidTargetsJson(pattern);
  json["files"] = summary.files;
  for (size_t c = 0; c < rig.names.size(); ++c) {
    json["cameras"].push_back({{"name", rig.names[c]}});
    json["cameras"].back().update(ToJson(localization.cameras[c]));
    if (summary.systematic_px[c])
      json["cameras"].back()["systematic_px"] = *summary.systematic_px[c];
  }
  return json;
}

void Print(const FixedRig& rig, const Pattern& pattern,
           const TargetLocalization& localization,
           const LocalizationSummary& summary, const std::string& folder) {
  PrintHowLocalized(pattern);
  fmt::print("{} pose{} in {} frame{}: {}", localization.poses.size(),
             localization.poses.size() == 1 ? "" : "s", summary.num_frames,
             summary.num_frames == 1 ? "" : "s",
             FormatErrorMetrics(summary.errors));
  if (summary.outside_area > 0)
    fmt::print("; {} outside the calibrated area", summary.outside_area);
  fmt::print(
      "\nnoise {:.2g} px per axis; standard deviation of a pose (median): "
      "{:.2g}°, {:.2g} mm\n",
      localization.noise_px, summary.rotation_stddev_rad * 180 / M_PI,
      1000 * summary.translation_stddev_m);
  if (summary.target_change_m)
    fmt::print("estimated target geometry: points moved by {:.3f} mm RMS\n",
               1000 * *summary.target_change_m);
  for (size_t c = 0; c < rig.names.size(); ++c) {
    const auto& residuals = localization.cameras[c].residuals;
    if (rig.is_rig)
      fmt::print("{}: {}\n", rig.names[c],
                 residuals.empty()
                     ? "no features"
                     : FormatErrorMetrics(ComputeErrorMetrics(residuals)));
    PrintRejectedImages(localization.cameras[c].rejected_images);
  }
  for (const std::string& file : summary.files)
    fmt::print("{}/{}\n", folder, file);
}

void RequireNoImageReplaced(const LocalizeArguments& arguments,
                            const std::vector<CameraImages>& cameras) {
  std::vector<std::string> inputs = {arguments.camera, arguments.features,
                                     arguments.pattern};
  for (const CameraImages& camera : cameras)
    inputs.insert(inputs.end(), camera.paths.begin(), camera.paths.end());
  std::vector<std::string> outputs;
  for (const char* name : kLocalizationFiles)
    outputs.push_back(
        (std::filesystem::path(arguments.output) / name).string());
  RequireNoInputReplaced(inputs, outputs);
}

// A result folder has files of the same names: estimated geometry, poses.
void RequireNoCalibration(const std::string& folder) {
  for (const char* name : {"result.json", "camera.yaml", "rig.yaml"})
    if (std::filesystem::exists(std::filesystem::path(folder) / name))
      throw Error(ExitCode::kOutputFailed,
                  fmt::format("{}: contains a calibration ({}), whose files "
                              "would be replaced; use another output folder",
                              folder, name));
}

// Replaces the files of an earlier localization.
std::vector<std::string> WriteLocalization(
    const std::string& folder,
    const std::vector<std::pair<std::string, std::string>>& contents) {
  OutputFolder output(folder);
  OutputFiles files;
  std::vector<std::string> names;
  for (const auto& [name, text] : contents) {
    if (text.empty()) continue;
    files.Add(output.path() + "/" + name, text);
    names.push_back(name);
  }
  files.Commit();
  output.Commit({std::begin(kLocalizationFiles), std::end(kLocalizationFiles)});
  return names;
}

void Run(const LocalizeArguments& arguments, const CommonOptions& common) {
  RequireOneSource(arguments);
  const FixedRig rig = ReadFixedRig(arguments.camera, common.at);
  const Pattern given = LoadCheckedPattern(arguments.pattern, common);
  Pattern pattern = given;
  if (arguments.independent_boards) pattern.rigid_targets.clear();
  RequireNoImageReplaced(arguments, {});
  RequireNoCalibration(arguments.output);
  RequireCreatableFolder(arguments.output);
  const std::vector<CameraImages> cameras =
      GatherFeatures(rig, pattern, arguments, common);
  RequireNoImageReplaced(arguments, cameras);
  for (const CameraImages& camera : cameras)
    RequireSeparateFolders(camera.paths, arguments.output);
  std::vector<Dataset> datasets;
  for (const CameraImages& camera : cameras) datasets.push_back(camera.dataset);

  RigModel model = LocalizingRig(rig, pattern);
  std::optional<double> target_change_m;
  if (arguments.estimate_target) {
    pattern = EstimateTargetGeometry(model, datasets, pattern, common.threads);
    model.rigid_targets = MakeRigidTargets(pattern);
    target_change_m = RmsDifference(pattern, given);
  }
  TargetLocalization localization =
      LocalizeTargets(model, datasets, pattern, common.threads);
  RequireLocalized(localization.poses.size());
  for (size_t c = 0; c < cameras.size(); ++c)
    for (const RejectedImage& image : cameras[c].skipped)
      localization.cameras[c].rejected_images.push_back(image);

  LocalizationSummary summary = Summarize(model, localization);
  summary.target_change_m = target_change_m;
  summary.files = WriteLocalization(
      arguments.output,
      {{"poses.csv", FormatTargetPoses(rig.names.front(), localization.poses)},
       {"residuals.csv", FormatHeldOutResiduals(rig, localization)},
       {kEstimatedPattern, target_change_m ? FormatPattern(pattern) : ""},
       {kPosesImage,
        EncodePoseSheet(rig, model, cameras, pattern, localization)}});
  for (size_t c = 0; c < cameras.size() && !common.quiet; ++c)
    WarnAboutIntrinsics(rig.is_rig ? rig.names[c] : "",
                        localization.cameras[c].residuals,
                        summary.systematic_px[c]);
  if (common.json)
    PrintCommandJson(ToJson(rig, pattern, localization, summary));
  else if (!common.quiet)
    Print(rig, pattern, localization, summary, arguments.output);
}

}  // namespace

void AddLocalize(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "localize", "Estimate the poses of targets with fixed intrinsics.",
      "raygrid localize result/camera.yaml photos/ --pattern "
      "result/pattern.yaml -o poses/",
      common);
  auto arguments = std::make_shared<LocalizeArguments>();
  command
      ->add_option("camera", arguments->camera, "camera.yaml, blob or rig.yaml")
      ->required();
  command->add_option("images", arguments->images,
                      "images, folders and bags, of a single camera");
  AddRigImageOptions(command, &arguments->folders, &arguments->sync_by,
                     &arguments->features);
  AddBagOptions(command, &arguments->bags, true);
  BeginGroup(command, help_group::kModel);
  AddAtOption(command, common);
  AddPatternOption(command, &arguments->pattern,
                   "; use the estimated geometry that calibrate wrote")
      ->required();
  AddYesOption(command, common);
  BeginGroup(command, help_group::kTarget);
  command->add_flag("--refine-target", arguments->estimate_target,
                    "estimate the target geometry, from at least 3 poses, and "
                    "write estimated_pattern.yaml");
  command->add_flag("--independent-boards", arguments->independent_boards,
                    "estimate a pose per board even if pattern.yaml declares a "
                    "rigid multi-board target");
  BeginGroup(command, help_group::kOutput);
  command
      ->add_option("-o,--output", arguments->output,
                   "output folder: poses.csv, residuals.csv and, with images, "
                   "poses.png")
      ->option_text("DIR")
      ->required();
  BeginGroup(command, help_group::kAdvanced);
  AddHugeOption(command);
  command->callback([arguments, common] {
    UseBags(common->quiet, arguments.get());
    Run(*arguments, *common);
  });
}

}  // namespace raygrid
