#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "camera/camera_frame.h"
#include "camera/equivalent_central_camera.h"
#include "camera_input.h"
#include "commands.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/rig_file.h"
#include "evaluation/rounded_text.h"
#include "help_formatter.h"
#include "image_size_option.h"
#include "json_output.h"
#include "packing/pack.h"
#include "packing/rectification.h"
#include "view_options.h"

namespace raygrid {
namespace {

constexpr char kPairFile[] = "rectified.yaml";

struct RectifyArguments {
  std::string rig, left, right, output, size;
  double max_error_px = 0.05;
  std::optional<double> alpha, hfov_deg;
  std::optional<double> distance_m;
};

// A camera of the pair, in the frame of its blob.
struct PairCamera {
  std::string name, path;
  CameraInput input;
  Eigen::Quaterniond blob_from_camera;
  Pose blob_from_rig;
  // The central approximation of a non-central camera at the scene distance;
  // null for central cameras.
  std::unique_ptr<CameraModel> at_distance = {};

  const CameraModel& central() const {
    return at_distance ? *at_distance : *input.file.camera;
  }
  StereoCamera MakeStereoCamera() const {
    return {name, central(), blob_from_rig};
  }
};

const RigFileCamera& GetRigCamera(const std::string& path,
                                  const std::vector<RigFileCamera>& cameras,
                                  const char* option, const std::string& name) {
  std::string names;
  for (const RigFileCamera& camera : cameras) {
    if (camera.name == name) return camera;
    names += (names.empty() ? "" : ", ") + camera.name;
  }
  throw Error(ExitCode::kUsage,
              fmt::format("{} {}: no such camera in {}, which has {}", option,
                          name, path, names));
}

PairCamera ReadPairCamera(const std::string& rig_path,
                          const RigFileCamera& camera) {
  const std::string path =
      (std::filesystem::path(rig_path).parent_path() / camera.file).string();
  PairCamera read = {camera.name, path, ReadCamera(path),
                     Eigen::Quaterniond::Identity(), camera.camera_from_rig};
  if (!read.input.blob)
    read.blob_from_camera = AlignToCanonicalFrame(&read.input.file.camera)
                                .value_or(read.blob_from_camera);
  read.blob_from_rig =
      Pose{read.blob_from_camera, {0, 0, 0}} * camera.camera_from_rig;
  return read;
}

// Approximates non-central cameras for scenes at one distance.
void SetDistance(const std::optional<double>& distance_m,
                 std::array<PairCamera, 2>* pair) {
  bool has_lines = false;
  for (PairCamera& camera : *pair) {
    if (camera.input.file.camera->IsCentral()) continue;
    has_lines = true;
    if (!distance_m)
      throw Error(
          ExitCode::kUsage,
          fmt::format(
              "{}: is non-central, so images can be rectified for one distance "
              "only; specify the distance of the scene with --distance METRES",
              camera.path));
    camera.at_distance = std::make_unique<EquivalentCentralCamera>(
        *camera.input.file.camera, *distance_m);
  }
  if (distance_m && !has_lines)
    throw Error(ExitCode::kUsage,
                "--distance is for non-central cameras only; omit it");
}

// The relative pose of the pair, with standard deviations if rig.yaml has its
// covariance.
struct PairGeometry {
  double angle_rad = 0;
  std::optional<double> baseline_sd_m, rotation_stddev_rad;
};

PairGeometry MakeGeometry(
    const RigFileCamera& left, const RigFileCamera& right,
    const std::vector<RelativePoseCovariance>& relative_poses) {
  PairGeometry geometry;
  geometry.angle_rad = left.camera_from_rig.rotation.angularDistance(
      right.camera_from_rig.rotation);
  const RelativePoseCovariance* pair =
      FindRelativePose(relative_poses, left.name, right.name);
  if (!pair) return geometry;
  const bool is_left_first = pair->first == left.name;
  const Pose& first = (is_left_first ? left : right).camera_from_rig;
  const Pose& second = (is_left_first ? right : left).camera_from_rig;
  geometry.baseline_sd_m =
      pair->DistanceStdDev((second * first.Inverse()).translation);
  geometry.rotation_stddev_rad = pair->RotationStdDev();
  return geometry;
}

struct RectifiedPair {
  std::array<PairCamera, 2> cameras;
  PairGeometry geometry;
};

RectifiedPair ReadPair(const RectifyArguments& arguments) {
  if (arguments.left == arguments.right)
    throw Error(
        ExitCode::kUsage,
        fmt::format(
            "--left and --right are both {}; specify two different cameras",
            arguments.left));
  const std::string text = ReadFile(arguments.rig);
  const auto cameras = ParseRigFile(arguments.rig, text);
  const RigFileCamera& left =
      GetRigCamera(arguments.rig, cameras, "--left", arguments.left);
  const RigFileCamera& right =
      GetRigCamera(arguments.rig, cameras, "--right", arguments.right);
  RectifiedPair pair = {
      {ReadPairCamera(arguments.rig, left),
       ReadPairCamera(arguments.rig, right)},
      MakeGeometry(left, right,
                   ParseRelativePoseCovariances(arguments.rig, text))};
  SetDistance(arguments.distance_m, &pair.cameras);
  return pair;
}

PackedCamera PackForPair(const PairCamera& camera, const VirtualView& view,
                         const RectifyArguments& arguments,
                         const CommonOptions& common) {
  CameraFile file = camera.input.file;
  file.name = camera.name;
  PackOptions options;
  options.remaps = {view};
  if (arguments.distance_m)
    options.remaps[0].scene = SceneSurface{*arguments.distance_m, {}};
  options.max_error_px = arguments.max_error_px;
  options.num_threads = common.threads;
  try {
    return PackCamera(file, options);
  } catch (const Error& error) {
    throw Error(error.code(), camera.path + ": " + error.what());
  }
}

// ---- Output ----------------------------------------------------------------

template <typename Matrix>
std::string FormatMatrix(const char* name, const Matrix& matrix) {
  std::string text = fmt::format("{}:\n", name);
  for (int row = 0; row < matrix.rows(); ++row) {
    text += "  - [";
    for (int column = 0; column < matrix.cols(); ++column)
      text += fmt::format("{}{}", column == 0 ? "" : ", ",
                          matrix(row, column) + 0.0);
    text += "]\n";
  }
  return text;
}

template <typename Matrix>
nlohmann::ordered_json MakeMatrixJson(const Matrix& matrix) {
  nlohmann::ordered_json rows = nlohmann::json::array();
  for (int row = 0; row < matrix.rows(); ++row) {
    nlohmann::ordered_json values = nlohmann::json::array();
    for (int column = 0; column < matrix.cols(); ++column)
      values.push_back(matrix(row, column) + 0.0);
    rows.push_back(values);
  }
  return rows;
}

// Returns the rotation of a camera into the rectified frame, from the frame of
// the camera's file.
Eigen::Matrix3d ComputePairRotation(const Rectification& rectified,
                                    const std::array<PairCamera, 2>& pair,
                                    int c) {
  return rectified.R(c) * pair[c].blob_from_camera.toRotationMatrix();
}

std::string FormatPair(const Rectification& rectified,
                       const std::array<PairCamera, 2>& pair,
                       const PairGeometry& geometry,
                       const RectifyArguments& arguments) {
  const ImageSize& size = rectified.views[0].size;
  std::string text =
      fmt::format("left: \"{}\"\nright: \"{}\"\n", pair[0].name, pair[1].name);
  text += rectified.is_vertical
              ? "orientation: vertical  # left is the upper camera; epipolar "
                "lines are columns\n"
              : "orientation: horizontal  # epipolar lines are rows\n";
  text += fmt::format("baseline: {}  # metres\n", rectified.baseline_m);
  if (geometry.baseline_sd_m)
    text += fmt::format("baseline_sd: {:.3g}  # metres, 1 sigma\n",
                        *geometry.baseline_sd_m);
  text += fmt::format("angle: {:.9g}  # radians, relative rotation\n",
                      geometry.angle_rad);
  if (geometry.rotation_stddev_rad)
    text += fmt::format("rotation_sd: {:.3g}  # radians, 1 sigma\n",
                        *geometry.rotation_stddev_rad);
  if (arguments.distance_m)
    text += fmt::format("distance: {}  # metres, distance of the scene\n",
                        *arguments.distance_m);
  text += fmt::format("image_size: [{}, {}]\n", size.width, size.height);
  text += "# As in OpenCV's stereoRectify; lengths in metres.\n";
  for (const int c : {0, 1})
    text += FormatMatrix(c == 0 ? "R1" : "R2",
                         ComputePairRotation(rectified, pair, c));
  for (const int c : {0, 1})
    text += FormatMatrix(c == 0 ? "P1" : "P2", rectified.P(c));
  text += FormatMatrix("Q", rectified.Q());
  // The required key comes last, so that truncated files are rejected.
  return text + "raygrid_rectified: 1\n";
}

// The paths of a camera's output files.
struct PairPaths {
  std::string blob, view;
};
PairPaths MakePairPaths(const std::string& folder, const std::string& name) {
  const std::filesystem::path path = folder;
  return {(path / (name + ".raygrid")).string(),
          (path / (name + ".camera.yaml")).string()};
}

nlohmann::ordered_json MakePairJson(const Rectification& rectified,
                                    const std::array<PairCamera, 2>& pair,
                                    const PairGeometry& geometry,
                                    const std::array<PackedCamera, 2>& packed,
                                    const RectifyArguments& arguments) {
  nlohmann::ordered_json json = {
      {"orientation", rectified.is_vertical ? "vertical" : "horizontal"},
      {"baseline_m", rectified.baseline_m}};
  if (geometry.baseline_sd_m) json["baseline_sd_m"] = *geometry.baseline_sd_m;
  json["angle_rad"] = geometry.angle_rad;
  if (geometry.rotation_stddev_rad)
    json["rotation_sd_rad"] = *geometry.rotation_stddev_rad;
  json["overlap_fraction"] = rectified.overlap;
  for (const int c : {0, 1}) {
    const PairPaths paths = MakePairPaths(arguments.output, pair[c].name);
    nlohmann::ordered_json own = {{"name", pair[c].name},
                                  {"blob", paths.blob},
                                  {"bytes", packed[c].blob.size()},
                                  {"view_file", paths.view}};
    own.update(MakeViewJson(rectified.views[c]));
    own["error_px"] = packed[c].remaps[0].error_px;
    own["warnings"] = packed[c].warnings;
    own["R"] = MakeMatrixJson(ComputePairRotation(rectified, pair, c));
    own["P"] = MakeMatrixJson(rectified.P(c));
    json[c == 0 ? "left" : "right"] = own;
  }
  json["Q"] = MakeMatrixJson(rectified.Q());
  return json;
}

void PrintPair(const Rectification& rectified,
               const std::array<PairCamera, 2>& pair,
               const PairGeometry& geometry,
               const std::array<PackedCamera, 2>& packed,
               const RectifyArguments& arguments) {
  fmt::print(
      "{} in {}: baseline {}, rotation {}, epipolar lines are {}s; {:.0f} % of "
      "{}'s image overlaps with {} at infinity\n",
      kPairFile, arguments.output,
      geometry.baseline_sd_m ? FormatWithStdDev(1e3 * rectified.baseline_m,
                                                1e3 * *geometry.baseline_sd_m) +
                                   " mm"
                             : fmt::format("{:.6g} m", rectified.baseline_m),
      geometry.rotation_stddev_rad
          ? FormatWithStdDev(geometry.angle_rad * 180 / M_PI,
                             *geometry.rotation_stddev_rad * 180 / M_PI) +
                " degrees"
          : fmt::format("{:.3g} degrees", geometry.angle_rad * 180 / M_PI),
      rectified.is_vertical ? "column" : "row", 100 * rectified.overlap,
      pair[0].name, pair[1].name);
  for (const int c : {0, 1})
    fmt::print(
        "{}.raygrid: {} bytes, remap error {:.2g} px; {}.camera.yaml: {}\n",
        pair[c].name, packed[c].blob.size(), packed[c].remaps[0].error_px,
        pair[c].name, FormatView(rectified.views[c]));
}

void Run(const RectifyArguments& arguments, const CommonOptions& common) {
  RectificationRequest request;
  if (!arguments.size.empty())
    request.size = ParseImageSize("--size", arguments.size);
  request.alpha = arguments.alpha;
  request.hfov_deg = arguments.hfov_deg;
  const RectifiedPair read = ReadPair(arguments);
  const std::array<PairCamera, 2>& pair = read.cameras;
  const PairGeometry& geometry = read.geometry;
  std::vector<std::string> inputs = {arguments.rig}, outputs;
  outputs.push_back(
      (std::filesystem::path(arguments.output) / kPairFile).string());
  for (const PairCamera& camera : pair) {
    inputs.push_back(camera.path);
    const PairPaths paths = MakePairPaths(arguments.output, camera.name);
    outputs.insert(outputs.end(), {paths.blob, paths.view});
    if (!common.quiet)
      WarnAboutFailedCalibration(camera.path, camera.input.file);
  }
  RequireNoInputReplaced(inputs, outputs);
  const Rectification rectified =
      Rectify(pair[0].MakeStereoCamera(), pair[1].MakeStereoCamera(), request);
  std::array<PackedCamera, 2> packed;
  OutputFiles files;
  files.Add(outputs[0], FormatPair(rectified, pair, geometry, arguments));
  for (const int c : {0, 1}) {
    const VirtualView& view = rectified.views[c];
    packed[c] = PackForPair(pair[c], view, arguments, common);
    const PairPaths paths = MakePairPaths(arguments.output, pair[c].name);
    files.Add(paths.blob, packed[c].blob);
    files.Add(paths.view, ViewCameraFile(view, pair[c].name));
  }
  files.Commit();
  for (const int c : {0, 1})
    for (const std::string& warning : packed[c].warnings)
      fmt::print(stderr, "raygrid: {}: {}\n", pair[c].path, warning);
  if (common.json)
    PrintCommandJson(
        MakePairJson(rectified, pair, geometry, packed, arguments));
  else if (!common.quiet)
    PrintPair(rectified, pair, geometry, packed, arguments);
}

}  // namespace

void AddRectify(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "rectify",
      "Rectify a stereo pair so that epipolar lines are image rows.",
      "raygrid rectify rig.yaml --left cam0 --right cam1 -o stereo/", common);
  auto arguments = std::make_shared<RectifyArguments>();
  command->add_option("rig", arguments->rig, "rig.yaml")->required();
  command
      ->add_option("--left", arguments->left,
                   "name of the left (or upper) camera")
      ->option_text("NAME")
      ->required();
  command
      ->add_option("--right", arguments->right,
                   "name of the right (or lower) camera")
      ->option_text("NAME")
      ->required();
  BeginGroup(command, help_group::kView);
  command
      ->add_option("--alpha", arguments->alpha,
                   "0: only pixels valid in both images; 1: all pixels of both "
                   "images (default: 0, with at most 120° field of view)")
      ->option_text("0..1");
  command
      ->add_option("--hfov", arguments->hfov_deg,
                   "horizontal field of view, instead of --alpha")
      ->option_text("DEG");
  command
      ->add_option("--size", arguments->size,
                   "image size of both rectified views in px (default: image "
                   "size of the left camera)")
      ->option_text("WxH");
  command
      ->add_option("--distance", arguments->distance_m,
                   "distance of the scene, for non-central cameras")
      ->check(AboveZero())
      ->option_text("M");
  command
      ->add_option("--max-error-px", arguments->max_error_px,
                   "maximum error allowed for the remap tables")
      ->option_text("PX")
      ->check(AboveZero())
      ->capture_default_str();
  BeginGroup(command, help_group::kOutput);
  command
      ->add_option("-o,--output", arguments->output,
                   "folder for NAME.raygrid, NAME.camera.yaml and "
                   "rectified.yaml (R1, R2, P1, P2, Q as in OpenCV)")
      ->option_text("DIR")
      ->required();
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
