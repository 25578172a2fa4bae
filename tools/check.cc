#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "calibration/camera_check.h"
#include "calibration_input.h"
#include "camera_input.h"
#include "dataset/error.h"
#include "dataset/image_files.h"
#include "dataset/text_encoding.h"
#include "evaluation/rounded_text.h"
#include "help_formatter.h"
#include "json_output.h"
#include "pattern_input.h"
#include "session_file.h"

namespace raygrid {
namespace {

struct CheckArguments {
  std::string camera, features, pattern;
  std::vector<std::string> images;
  BagOptions bags;
};

std::string PatternPath(const CheckArguments& arguments) {
  if (!arguments.pattern.empty()) return arguments.pattern;
  const std::filesystem::path beside =
      std::filesystem::path(arguments.camera).parent_path() / "pattern.yaml";
  if (!std::filesystem::exists(beside))
    throw Error(ExitCode::kUsage,
                "check: no pattern.yaml beside the camera; pass one with "
                "--pattern, preferably the one written by calibrate");
  return beside.string();
}

// Replaces the folder of a capture session by its images. Returns the
// differences between the session's capture settings and those of the
// calibration.
std::vector<std::string> UseSession(const CameraFile& file,
                                    CheckArguments* arguments) {
  if (arguments->images.size() != 1 || !IsSession(arguments->images[0]))
    return {};
  const std::string folder = arguments->images[0];
  const std::vector<Session> cameras = ReadSession(folder);
  if (cameras.size() > 1)
    throw Error(ExitCode::kUsage,
                fmt::format("{}: is a session of a rig; check each camera "
                            "separately, with {}/{}/NAME",
                            folder, folder, kSessionFrames));
  arguments->images.clear();
  for (const SessionFrame& frame : cameras[0].frames)
    arguments->images.push_back(SessionFramePath(folder, "", frame.image));
  if (arguments->images.empty())
    throw Error(ExitCode::kInsufficientData,
                folder +
                    ": no frame was kept; continue the "
                    "session with raygrid capture --resume");
  return file.capture
             ? ListDifferences(*file.capture, GetCaptureSettings(cameras[0]))
             : std::vector<std::string>();
}

// Detects the features in the images. Images without a detection are added to
// the rejected ones.
Dataset Gather(const CheckArguments& arguments, const CommonOptions& common,
               const CameraFile& file, const Pattern& pattern,
               std::vector<RejectedImage>* rejected) {
  const ImageSize size = file.camera->image_size();
  if (!arguments.features.empty())
    return ReadCameraFeatures(arguments.features, size, pattern);
  Measurements measurements =
      Measure(arguments.images, pattern, PatternPath(arguments), common, {});
  for (const auto& images : {measurements.skipped, measurements.left_out})
    rejected->insert(rejected->end(), images.begin(), images.end());
  Dataset dataset = std::move(measurements.dataset);
  if (dataset.num_features() == 0)
    throw Error(ExitCode::kInsufficientData, "no target found in the images");
  if (dataset.image_size != size)
    throw InputError(
        fmt::format("the images have {} x {} pixels, the camera {} x {}; use "
                    "images of the calibrated sensor mode",
                    dataset.image_size.width, dataset.image_size.height,
                    size.width, size.height));
  return dataset;
}

const char* Word(const CameraChange& change) {
  return change.is_degraded     ? "DEGRADED"
         : change.is_conclusive ? "OK"
                                : "INCONCLUSIVE";
}

nlohmann::ordered_json ToJson(const CameraCheck& check,
                              const std::vector<std::string>& stands) {
  const CameraChange& change = check.change;
  nlohmann::ordered_json json = {{"status", Word(change)},
                                 {"significant_changes", change.moved},
                                 {"images", check.num_images},
                                 {"features", change.num_features},
                                 {"noise_px", change.noise_px},
                                 {"global_z_score", change.smooth_sigmas},
                                 {"local_z_score", change.local_sigmas},
                                 {"rms_change_px", change.rms_px}};
  for (const Movement& movement : change.movements) {
    nlohmann::ordered_json& entry = json["changes"][movement.name];
    entry["z_score"] = movement.sigmas;
    if (movement.detection_limit > 0)
      entry["detection_limit"] = movement.detection_limit;
    for (size_t k = 0; k < movement.parameters.size(); ++k) {
      entry[movement.parameters[k]] = movement.values[k];
      entry[movement.parameters[k] + "_sd"] = movement.deviations[k];
    }
  }
  if (change.max_local_px > 0)
    json["changes"]["local"]["largest"] = {{"px", change.max_local_px},
                                           {"x", change.max_local_pixel.x()},
                                           {"y", change.max_local_pixel.y()}};
  if (!stands.empty()) json["changed_settings"] = stands;
  json["rejected_images"] = nlohmann::ordered_json::array();
  for (const RejectedImage& image : check.rejected_images)
    json["rejected_images"].push_back(
        {{"image", image.image}, {"reason", image.reason}});
  return json;
}

std::string Amount(const CameraChange& change, const Movement& movement) {
  const auto pair = [&movement](double unit, const char* name) {
    return fmt::format("({0}, {1}) {2}; smallest detectable change {3:.2g} {2}",
                       FormatWithStdDev(unit * movement.values[0],
                                        unit * movement.deviations[0]),
                       FormatWithStdDev(unit * movement.values[1],
                                        unit * movement.deviations[1]),
                       name, unit * movement.detection_limit);
  };
  if (movement.name == "scale")
    return fmt::format("{} %; smallest detectable change {:.2g} %",
                       FormatWithStdDev(100 * movement.values[0],
                                        100 * movement.deviations[0]),
                       100 * movement.detection_limit);
  if (movement.name == "shift") return pair(1, "px");
  if (movement.name == "tilt") return pair(180 / M_PI, "degrees");
  if (change.max_local_px <= 0) return "";
  return fmt::format("max {:.2g} px near ({:.0f}, {:.0f})", change.max_local_px,
                     change.max_local_pixel.x(), change.max_local_pixel.y());
}

void Print(const CameraCheck& check, const std::vector<std::string>& stands) {
  const CameraChange& change = check.change;
  fmt::print("{}", Word(change));
  if (change.is_degraded)
    fmt::print(": significant change in {}", fmt::join(change.moved, " and "));
  fmt::print(
      "\n  {} images, {} features, noise {:.2g} px per axis; change {:.2g} px "
      "RMS after pose estimation\n",
      check.num_images, change.num_features, change.noise_px, change.rms_px);
  for (const Movement& movement : change.movements)
    fmt::print("  {:<6} {:>7.1f} sigma  {}\n", movement.name, movement.sigmas,
               Amount(change, movement));
  fmt::print(
      "  each kind of change is tested separately; the smallest detectable "
      "change is found in 99 % of cases; shift and tilt are hard to "
      "distinguish\n");
  for (const std::string& difference : stands)
    fmt::print("  capture settings differ: {}\n", difference);
  for (const RejectedImage& image : check.rejected_images)
    fmt::print("rejected: {} ({})\n", Printable(image.image),
               Printable(image.reason));
}

void Run(CheckArguments arguments, const CommonOptions& common) {
  if (arguments.images.empty() == arguments.features.empty())
    throw Error(ExitCode::kUsage, "check: specify either images or --features");
  const CameraInput input = ReadCamera(arguments.camera, common.at);
  const std::vector<std::string> stands = UseSession(input.file, &arguments);
  arguments.images = ExpandBags(arguments.images, arguments.bags, common.quiet);
  const Pattern pattern = LoadPattern(PatternPath(arguments));
  std::vector<RejectedImage> rejected;
  const Dataset dataset =
      Gather(arguments, common, input.file, pattern, &rejected);
  CameraCheck check = CheckCamera(input.file, dataset, pattern, common.threads);
  check.rejected_images.insert(check.rejected_images.end(), rejected.begin(),
                               rejected.end());
  if (common.json)
    PrintCommandJson(ToJson(check, stands));
  else if (!common.quiet)
    Print(check, stands);
  if (check.change.is_degraded)
    throw Error(ExitCode::kQualityTooLow,
                fmt::format("the camera has changed ({}); calibrate it again",
                            fmt::join(check.change.moved, ", ")));
  if (!check.change.is_conclusive)
    throw Error(ExitCode::kInsufficientData,
                "inconclusive: no change detected, but a shift or scale change "
                "of 1 % of the image would go undetected; take more or sharper "
                "images, with the target tilted and filling the image");
}

}  // namespace

void AddCheck(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "check",
      "Check from a few images whether a calibration is still valid.",
      "raygrid check result/camera.yaml field/*.jpg", common);
  auto arguments = std::make_shared<CheckArguments>();
  command
      ->add_option("camera", arguments->camera,
                   "camera.yaml written by calibrate, including its covariance")
      ->required();
  command->add_option("images", arguments->images,
                      "images, folders, a capture session or bags");
  command
      ->add_option("--features", arguments->features,
                   "features.csv instead of images")
      ->option_text("FILE");
  AddBagOptions(command, &arguments->bags, false);
  BeginGroup(command, help_group::kModel);
  AddAtOption(command, common);
  AddPatternOption(command, &arguments->pattern,
                   " (default: pattern.yaml beside the camera)");
  AddHugeOption(command);
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
