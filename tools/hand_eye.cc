#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "calibration/target_localization.h"
#include "commands.h"
#include "dataset/csv.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/image_times.h"
#include "dataset/output_folder.h"
#include "dataset/robot_poses.h"
#include "dataset/text_encoding.h"
#include "fixed_rig.h"
#include "hand_eye/hand_eye_calibration.h"
#include "hand_eye/hand_eye_diagnosis.h"
#include "hand_eye/hand_eye_file.h"
#include "hand_eye/hand_eye_input.h"
#include "help_formatter.h"
#include "json_output.h"
#include "pattern_input.h"

namespace raygrid {
namespace {

struct HandEyeArguments {
  std::string result, robot, output, image_times;
  std::string convention = "base_from_gripper", unit = "m";
  bool eye_in_hand = false, eye_to_hand = false;
  std::optional<double> sigma_mm, sigma_deg;
  std::optional<int> board;
  double max_time_gap_s = 0.02;

  Mounting mounting() const {
    return eye_to_hand ? Mounting::kEyeToHand : Mounting::kEyeInHand;
  }
};

constexpr const char* kHandEyeFile = "hand_eye.yaml";
constexpr const char* kHandEyeResiduals = "hand_eye_residuals.csv";
constexpr double kToDegrees = 180 / M_PI;

// ---- Poses of the target ---------------------------------------------------

// Poses of targets relative to a camera.
struct TargetPoses {
  std::string camera;  // its name; empty if there is one
  std::vector<TargetPose> poses;
  std::vector<std::string> files;  // that were read
};

bool HasCovariances(const std::string& text) {
  return text.find("cov_rx_rx") != std::string::npos;
}

TargetPoses SelectCamera(const std::string& path,
                         std::map<std::string, std::vector<TargetPose>> poses) {
  if (poses.empty()) throw InputError(path + ": no poses");
  if (poses.size() > 1)
    throw InputError(fmt::format(
        "{}: contains poses of cameras '{}' and '{}'; keep those of one", path,
        poses.begin()->first, std::next(poses.begin())->first));
  return {poses.begin()->first, std::move(poses.begin()->second), {path}};
}

// The cameras of a result folder and their features, which calibrate writes.
TargetPoses LocalizeResult(const std::filesystem::path& folder,
                           const CommonOptions& common) {
  const bool is_rig = std::filesystem::exists(folder / "rig.yaml");
  const std::string camera =
      (folder / (is_rig ? "rig.yaml" : "camera.yaml")).string();
  const std::string features = (folder / "features.csv").string();
  const std::string target = (folder / "pattern.yaml").string();
  const FixedRig rig = ReadFixedRig(camera, common.at);
  const Pattern pattern = LoadPattern(target);
  const std::vector<Dataset> datasets = ReadRigFeatures(rig, features, pattern);
  TargetPoses targets = {rig.names.front(),
                         LocalizeTargets(LocalizingRig(rig, pattern), datasets,
                                         pattern, common.threads)
                             .poses,
                         {camera, features, target}};
  RequireLocalized(targets.poses.size());
  return targets;
}

TargetPoses ReadTargets(const std::string& result,
                        const CommonOptions& common) {
  if (!std::filesystem::is_directory(result)) {
    const std::string text = ReadFile(result);
    if (!HasCovariances(text))
      throw InputError(result +
                       ": not a poses.csv with covariances; specify the folder "
                       "that calibrate or localize wrote");
    return SelectCamera(result, ParseTargetPoses(result, text));
  }
  const std::filesystem::path folder(result);
  const std::string path = (folder / "poses.csv").string();
  if (std::filesystem::exists(path)) {
    const std::string text = ReadFile(path);
    if (HasCovariances(text))
      return SelectCamera(path, ParseTargetPoses(path, text));
  }
  if (std::filesystem::exists(folder / "features.csv"))
    return LocalizeResult(folder, common);
  throw InputError(result +
                   ": contains neither poses.csv of localize nor camera.yaml, "
                   "features.csv and pattern.yaml of calibrate");
}

// Keeps the poses of one board: that which is given, or observed most often.
// Returns how many others there are.
int KeepOneBoard(const HandEyeArguments& arguments, TargetPoses* targets) {
  std::map<int, int> counts;
  for (const TargetPose& target : targets->poses) ++counts[target.pose.board];
  int board = arguments.board.value_or(counts.begin()->first);
  if (!arguments.board)
    for (const auto& [id, count] : counts)
      if (count > counts[board]) board = id;
  if (counts.count(board) == 0)
    throw Error(ExitCode::kUsage, fmt::format("--board {}: no pose of it in {}",
                                              board, targets->files.front()));
  targets->poses.erase(
      std::remove_if(
          targets->poses.begin(), targets->poses.end(),
          [&](const TargetPose& target) { return target.pose.board != board; }),
      targets->poses.end());
  return static_cast<int>(counts.size()) - 1;
}

// ---- The robot's poses -----------------------------------------------------

// Everything that the calibration is based on, with remarks.
struct HandEyeInput {
  std::string camera;
  std::vector<HandEyeObservation> observations;
  std::vector<std::string> unmatched;  // images without a robot pose
  std::vector<std::string> warnings;
};

void RequireSeparateOutputs(const HandEyeArguments& arguments,
                            const TargetPoses& targets) {
  std::vector<std::string> inputs = targets.files;
  inputs.push_back(arguments.robot);
  inputs.push_back(arguments.image_times);
  const std::filesystem::path folder(arguments.output);
  RequireNoInputReplaced(inputs, {(folder / kHandEyeFile).string(),
                                  (folder / kHandEyeResiduals).string()});
}

std::vector<std::string> ListImages(const TargetPoses& targets) {
  std::vector<std::string> images;
  for (const TargetPose& target : targets.poses)
    images.push_back(target.pose.image);
  return images;
}

HandEyeInput ReadHandEyeInput(const HandEyeArguments& arguments,
                              const CommonOptions& common) {
  TargetPoses targets = ReadTargets(arguments.result, common);
  RequireSeparateOutputs(arguments, targets);
  RequireCreatableFolder(arguments.output);
  const int other_boards = KeepOneBoard(arguments, &targets);
  const RobotPoses robot =
      ParseRobotPoses(arguments.robot, ReadFile(arguments.robot),
                      {arguments.unit == "mm" ? 1e-3 : 1.0,
                       arguments.convention == "gripper_from_base"});
  MatchingOptions matching;
  matching.max_time_gap_s = arguments.max_time_gap_s;
  if (!arguments.image_times.empty())
    matching.image_times = ReadImageTimes(arguments.image_times);
  const std::vector<std::string> images = ListImages(targets);
  const MatchedRobotPoses matched =
      MatchRobotPoses(arguments.robot, robot, images, matching);

  HandEyeInput input;
  input.camera = targets.camera;
  input.observations = MakeHandEyeObservations(targets.poses, matched.by_image);
  for (const std::string& image : images)
    if (matched.by_image.count(image) == 0) input.unmatched.push_back(image);
  if (robot.num_normalized > 0)
    input.warnings.push_back(fmt::format(
        "{}: {} of {} rotations were not of unit length and were normalized",
        arguments.robot, robot.num_normalized, robot.poses.size()));
  if (other_boards > 0)
    input.warnings.push_back(fmt::format(
        "the poses of board {} are used, not those of {} other board{}; select "
        "another one with --board",
        targets.poses.front().pose.board, other_boards,
        other_boards == 1 ? "" : "s"));
  if (!input.unmatched.empty())
    input.warnings.push_back(fmt::format(
        "{} of {} images have no robot pose, such as {}",
        input.unmatched.size(), images.size(), input.unmatched.front()));
  return input;
}

// ---- Output ----------------------------------------------------------------

nlohmann::ordered_json ToJson(const Pose& pose) {
  Eigen::Quaterniond q = pose.rotation;
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const Eigen::Vector3d& t = pose.translation;
  return {
      {"rotation", {{"w", q.w()}, {"x", q.x()}, {"y", q.y()}, {"z", q.z()}}},
      {"translation", {{"x", t.x()}, {"y", t.y()}, {"z", t.z()}}}};
}

nlohmann::ordered_json ToJson(const NamedTransform& transform) {
  nlohmann::ordered_json json = {{"name", transform.name}};
  json.update(ToJson(transform.pose));
  json["rotation_sd_rad"] = transform.RotationStdDev();
  json["translation_sd_m"] = transform.TranslationStdDev();
  for (int i = 0; i < 6; ++i) {
    nlohmann::ordered_json row;
    for (int k = 0; k < 6; ++k) row.push_back(transform.covariance(i, k));
    json["covariance"].push_back(row);
  }
  return json;
}

nlohmann::ordered_json ToJson(const HandEyeErrorMetrics& errors) {
  return {{"rms_px", errors.rms.rms_px},
          {"translation_m", errors.rms.translation_m},
          {"rotation_rad", errors.rms.rotation_rad},
          {"count", errors.count}};
}

nlohmann::ordered_json ToJson(const SuggestedPose& suggestion) {
  nlohmann::ordered_json json = {
      {"near_image", suggestion.near_image},
      {"axis", std::string(1, suggestion.axis)},
      {"angle_rad", suggestion.angle_rad},
      {"base_from_gripper", ToJson(suggestion.base_from_gripper)},
      {"rotation_sd_rad", suggestion.new_rotation_stddev_rad},
      {"translation_sd_m", suggestion.new_translation_stddev_m}};
  return json;
}

nlohmann::ordered_json ToJson(const HandEyeArguments& arguments,
                              const HandEyeInput& input,
                              const HandEyeResult& result) {
  const Mounting mounting = arguments.mounting();
  nlohmann::ordered_json json = {
      {"mounting", arguments.eye_to_hand ? "eye-to-hand" : "eye-in-hand"},
      {"camera", input.camera},
      {"num_poses", input.observations.size()},
      {"num_used", result.NumUsed()}};
  for (const NamedTransform& transform : ListTransforms(result.fit, mounting))
    json["transforms"].push_back(ToJson(transform));
  json["robot_sigma_rad"] = result.fit.noise.rotation_rad;
  json["robot_sigma_m"] = result.fit.noise.translation_m;
  json["variance_ratio"] = result.variance_ratio;
  json["residual"] = ToJson(result.residual);
  json["held_out"] = ToJson(result.held_out);
  if (result.scale) {
    json["scale"] = 1 + result.scale->value;
    json["scale_sd"] = result.scale->stddev;
  }
  for (int k = 0; k < 3; ++k)
    json["rotation_spread_rad"].push_back(result.rotations.Rms(k));
  json["information_eigenvalues"] = std::vector<double>(
      result.information.data(), result.information.data() + 12);
  if (result.suggestion) json["suggestion"] = ToJson(*result.suggestion);
  json["rejected_images"] = nlohmann::ordered_json::array();
  for (size_t i = 0; i < result.poses.size(); ++i)
    if (!result.poses[i].is_used)
      json["rejected_images"].push_back({{"image", input.observations[i].image},
                                         {"reason", result.poses[i].reason}});
  for (const std::string& image : input.unmatched)
    json["rejected_images"].push_back(
        {{"image", image}, {"reason", "no robot pose"}});
  json["warnings"] = input.warnings;
  for (const std::string& warning : result.warnings)
    json["warnings"].push_back(warning);
  json["files"] = {kHandEyeFile, kHandEyeResiduals};
  return json;
}

std::string FormatError(const HandEyeError& error) {
  return fmt::format("{:.3g} px, {:.3g} mm, {:.2g}°", error.rms_px,
                     1000 * error.translation_m,
                     error.rotation_rad * kToDegrees);
}

// The direction in which the camera's position on its mount is known least.
std::string FormatWeakestDirection(const NamedTransform& mount_from_camera,
                                   const HandEyeNames& names) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
      mount_from_camera.covariance.bottomRightCorner<3, 3>());
  Eigen::Vector3d axis = solver.eigenvectors().col(2);
  int largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  if (axis[largest] < 0) axis = -axis;
  return fmt::format("[{:.2f}, {:.2f}, {:.2f}] of the {} (sd {:.2g} mm)",
                     axis.x() + 0.0, axis.y() + 0.0, axis.z() + 0.0,
                     names.mount,
                     1000 * std::sqrt(std::max(solver.eigenvalues()[2], 0.0)));
}

void PrintTransforms(const HandEyeResult& result, Mounting mounting) {
  for (const NamedTransform& transform : ListTransforms(result.fit, mounting)) {
    Eigen::Quaterniond q = transform.pose.rotation;
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    const Eigen::Vector3d& t = transform.pose.translation;
    fmt::print(
        "{}: translation [{:.5f}, {:.5f}, {:.5f}] m, quaternion wxyz "
        "[{:.6f}, {:.6f}, {:.6f}, {:.6f}]; sd {:.2g} mm, {:.2g}°\n",
        transform.name, t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z(),
        1000 * transform.TranslationStdDev(),
        transform.RotationStdDev() * kToDegrees);
  }
}

void PrintSuggestion(const SuggestedPose& suggestion) {
  const Eigen::Vector3d& t = suggestion.base_from_gripper.translation;
  const Eigen::Quaterniond& q = suggestion.base_from_gripper.rotation;
  fmt::print(
      "best additional pose: as {}, with the camera moved around the target's "
      "{} axis by {:.0f}°: base_from_gripper [{:.4f}, {:.4f}, {:.4f}] m, "
      "quaternion wxyz [{:.5f}, {:.5f}, {:.5f}, {:.5f}]; sd {:.2g} mm, "
      "{:.2g}° instead of {:.2g} mm, {:.2g}°\n",
      Printable(suggestion.near_image), suggestion.axis,
      suggestion.angle_rad * kToDegrees, t.x(), t.y(), t.z(), q.w(), q.x(),
      q.y(), q.z(), 1000 * suggestion.new_translation_stddev_m,
      suggestion.new_rotation_stddev_rad * kToDegrees,
      1000 * suggestion.translation_stddev_m,
      suggestion.rotation_stddev_rad * kToDegrees);
}

void Print(const HandEyeArguments& arguments, const HandEyeInput& input,
           const HandEyeResult& result) {
  const Mounting mounting = arguments.mounting();
  const bool is_stated = arguments.sigma_mm && arguments.sigma_deg;
  fmt::print("{} of {} poses, {}\n", result.NumUsed(),
             input.observations.size(),
             arguments.eye_to_hand ? "eye-to-hand" : "eye-in-hand");
  PrintTransforms(result, mounting);
  fmt::print("robot accuracy per axis{}: {:.2g} mm, {:.2g}°\n",
             is_stated ? "" : " (estimated)",
             1000 * result.fit.noise.translation_m,
             result.fit.noise.rotation_rad * kToDegrees);
  fmt::print("residual RMS: {}\n", FormatError(result.residual.rms));
  if (result.held_out.count > 0)
    fmt::print("held-out RMS: {}\n", FormatError(result.held_out.rms));
  fmt::print(
      "rotations of the gripper: RMS {:.0f}°, {:.0f}° and {:.0f}° about three "
      "axes; the camera's position is least certain along {}\n",
      result.rotations.Rms(0) * kToDegrees,
      result.rotations.Rms(1) * kToDegrees,
      result.rotations.Rms(2) * kToDegrees,
      FormatWeakestDirection(ListTransforms(result.fit, mounting)[1],
                             GetFrameNames(mounting)));
  if (result.suggestion) PrintSuggestion(*result.suggestion);
  for (size_t i = 0; i < result.poses.size(); ++i)
    if (!result.poses[i].is_used)
      fmt::print("rejected: {} ({})\n", Printable(input.observations[i].image),
                 Printable(result.poses[i].reason));
  for (const char* file : {kHandEyeFile, kHandEyeResiduals})
    fmt::print("{}/{}\n", arguments.output, file);
}

void Run(const HandEyeArguments& arguments, const CommonOptions& common) {
  const Mounting mounting = arguments.mounting();
  const HandEyeInput input = ReadHandEyeInput(arguments, common);
  RequireSameUnit(input.observations, mounting);
  StatedRobotNoise stated;
  if (arguments.sigma_mm) stated.translation_m = *arguments.sigma_mm / 1000;
  if (arguments.sigma_deg)
    stated.rotation_rad = *arguments.sigma_deg / kToDegrees;
  const HandEyeResult result =
      CalibrateHandEye(input.observations, mounting, stated);
  OutputFiles files;
  const std::filesystem::path folder(arguments.output);
  files.Add((folder / kHandEyeFile).string(),
            FormatHandEye(input.camera, mounting, result));
  files.Add((folder / kHandEyeResiduals).string(),
            FormatHandEyeResiduals(input.observations, result));
  files.Commit();
  if (!common.quiet)
    for (const auto& warnings : {input.warnings, result.warnings})
      for (const std::string& warning : warnings)
        fmt::print(stderr, "raygrid: {}\n", Printable(warning));
  if (common.json)
    PrintCommandJson(ToJson(arguments, input, result));
  else if (!common.quiet)
    Print(arguments, input, result);
}

void AddRobotOptions(CLI::App* command, HandEyeArguments* arguments) {
  command
      ->add_option("--robot", arguments->robot,
                   "robot poses by image name or time: CSV with a header, TUM "
                   "(name tx ty tz qx qy qz qw) or 4 x 4 matrices")
      ->option_text("FILE")
      ->required();
  command
      ->add_option("--robot-convention", arguments->convention,
                   "meaning of the robot poses: base_from_gripper or "
                   "gripper_from_base (default: base_from_gripper)")
      ->check(CLI::IsMember({"base_from_gripper", "gripper_from_base"}))
      ->option_text("NAME");
  command
      ->add_option("--robot-unit", arguments->unit,
                   "unit of the robot's lengths: m or mm (default: m)")
      ->check(CLI::IsMember({"m", "mm"}))
      ->option_text("UNIT");
  command
      ->add_option("--image-times", arguments->image_times,
                   "CSV file with the columns image and time_s, if images are "
                   "not named by time")
      ->option_text("FILE");
  command
      ->add_option("--max-time-gap", arguments->max_time_gap_s,
                   "largest time from an image to a robot pose in seconds "
                   "(default: 0.02)")
      ->check(AboveZero())
      ->option_text("S");
}

void AddHandEyeModelOptions(CLI::App* command, HandEyeArguments* arguments) {
  BeginGroup(command, help_group::kModel);
  CLI::Option* in_hand = command->add_flag(
      "--eye-in-hand", arguments->eye_in_hand,
      "camera on the gripper, target fixed to the base (default)");
  command
      ->add_flag("--eye-to-hand", arguments->eye_to_hand,
                 "camera fixed to the base, target in the gripper")
      ->excludes(in_hand);
  command
      ->add_option("--robot-sigma-mm", arguments->sigma_mm,
                   "standard deviation of the gripper's position per axis "
                   "(default: estimated)")
      ->check(AboveZero())
      ->option_text("MM");
  command
      ->add_option("--robot-sigma-deg", arguments->sigma_deg,
                   "standard deviation of the gripper's orientation per axis "
                   "(default: estimated)")
      ->check(AboveZero())
      ->option_text("DEG");
  BeginGroup(command, help_group::kTarget);
  command
      ->add_option("--board", arguments->board,
                   "board whose poses are used (default: the one observed most "
                   "often)")
      ->option_text("ID");
}

}  // namespace

void AddHandEye(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "hand-eye", "Estimate the pose of a camera on a robot.",
      "raygrid hand-eye result/ --robot poses.csv -o hand_eye/", common);
  auto arguments = std::make_shared<HandEyeArguments>();
  command
      ->add_option("result", arguments->result,
                   "folder that localize or calibrate wrote, or poses.csv")
      ->required();
  AddRobotOptions(command, arguments.get());
  AddHandEyeModelOptions(command, arguments.get());
  BeginGroup(command, help_group::kModel);
  AddAtOption(command, common);
  BeginGroup(command, help_group::kOutput);
  command
      ->add_option("-o,--output", arguments->output,
                   "output folder: hand_eye.yaml and hand_eye_residuals.csv")
      ->option_text("DIR")
      ->required();
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
