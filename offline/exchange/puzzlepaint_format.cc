#include "exchange/puzzlepaint_format.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>

#include "camera/noncentral_generic.h"
#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "dataset/yaml_file.h"
#include "exchange/camera_keys.h"
#include "exchange/puzzlepaint_files.h"
#include "exchange/puzzlepaint_state.h"
#include "exchange/unit_grid.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kCentral[] = "CentralGenericModel";
constexpr char kLines[] = "NoncentralGenericModel";
constexpr char kFirstX[] = "calibration_min_x";

const std::vector<ExternalModel>& GetPuzzlepaintModels() {
  static const std::vector<ExternalModel> external_models = {
      {kCentral, models::kCentralGeneric, {}},
      {kLines, models::kNonCentralGeneric, {}}};
  return external_models;
}

// ---- Reading ---------------------------------------------------------------

const ExternalModel& FindPuzzlepaintModel(const YAML::Node& root) {
  if (!root["type"] || !root["type"].IsScalar())
    throw InputError("'type' is missing");
  const std::string type = root["type"].as<std::string>();
  // Older files name the same models ...BSplineModel.
  std::string name = type;
  if (const size_t at = name.find("BSplineModel"); at != std::string::npos)
    name.replace(at, std::string::npos, "Model");
  for (const ExternalModel& external_model : GetPuzzlepaintModels())
    if (external_model.name == name) return external_model;
  throw InputError(fmt::format("unsupported type '{}'; supported are {} and {}",
                               Printable(type), kCentral, kLines));
}

int PixelNumber(const YAML::Node& root, const std::string& name, int side) {
  const double number = FiniteNumber(root[name], name);
  if (!(number >= 0 && number < side) || number != std::floor(number))
    throw InputError(fmt::format("{}: not a pixel of the image", name));
  return static_cast<int>(number);
}

UnitGrid::Bounds ReadBounds(const YAML::Node& root, const ImageSize& size) {
  const UnitGrid::Bounds bounds = {
      PixelNumber(root, kFirstX, size.width),
      PixelNumber(root, "calibration_min_y", size.height),
      PixelNumber(root, "calibration_max_x", size.width),
      PixelNumber(root, "calibration_max_y", size.height)};
  if (bounds.min_x >= bounds.max_x || bounds.min_y >= bounds.max_y)
    throw InputError("calibration_min and calibration_max: empty area");
  return bounds;
}

int GridSide(const YAML::Node& root, const std::string& name) {
  constexpr int kLeast = 4, kMost = 1027;
  const double side = FiniteNumber(root[name], name);
  if (!(side >= kLeast && side <= kMost) || side != std::floor(side))
    throw InputError(fmt::format("{}: must be {} to {}", name, kLeast, kMost));
  return static_cast<int>(side);
}

std::vector<Eigen::Vector3d> ReadVectors(const YAML::Node& root,
                                         const std::string& name, int count) {
  const std::vector<double> numbers =
      FiniteNumbers(root[name], name, 3 * count);
  std::vector<Eigen::Vector3d> vectors;
  for (int k = 0; k < count; ++k)
    vectors.emplace_back(numbers[3 * k], numbers[3 * k + 1],
                         numbers[3 * k + 2]);
  return vectors;
}

// Normalizes directions to unit length, as the program itself does when it
// loads them.
std::vector<Eigen::Vector3d> ComputeDirections(const YAML::Node& root,
                                               const std::string& name,
                                               int count) {
  std::vector<Eigen::Vector3d> directions = ReadVectors(root, name, count);
  for (Eigen::Vector3d& direction : directions) {
    if (!(direction.norm() > 1e-6))
      throw InputError(fmt::format("{}: zero-length direction", name));
    direction.normalize();
  }
  return directions;
}

UnitGrid ReadGrid(const YAML::Node& root, const ExternalModel& external_model) {
  const ImageSize size = {SidePx(root["width"], "width"),
                          SidePx(root["height"], "height")};
  const int columns = GridSide(root, "grid_width"),
            rows = GridSide(root, "grid_height");
  const bool has_points = external_model.name == kLines;
  return {size,
          ReadBounds(root, size),
          columns,
          rows,
          ComputeDirections(root, has_points ? "direction_grid" : "grid",
                            columns * rows),
          has_points ? ReadVectors(root, "point_grid", columns * rows)
                     : std::vector<Eigen::Vector3d>{}};
}

std::shared_ptr<const CameraModel> FitNearestCamera(const UnitGrid& grid) {
  const int columns = grid.columns(), rows = grid.rows();
  if (grid.IsCentral())
    return std::make_shared<CentralGeneric>(
        FitCentralGeneric(grid, grid.area(), columns, rows));
  return std::make_shared<NonCentralGeneric>(
      FitNonCentralGeneric(grid, grid.area(), columns, rows));
}

ConvertedCamera ReadPuzzlepaintIntrinsics(const YAML::Node& root,
                                          std::vector<std::string>* warnings) {
  ConvertedCamera lens;
  lens.external_model = &FindPuzzlepaintModel(root);
  const UnitGrid grid = ReadGrid(root, *lens.external_model);
  lens.size = grid.image_size();
  const CameraKeys keys(root);
  keys.Skip({"type", "width", "height", "calibration_*", "grid_width",
             "grid_height", "grid", "point_grid", "direction_grid"});
  keys.Finish(*lens.external_model, warnings);
  lens.grid = FitNearestCamera(grid);
  const ModelFit fit =
      ComputeModelFit(grid, nullptr, *lens.grid, *lens.external_model,
                      Eigen::Quaterniond::Identity());
  warnings->push_back(
      "converted from a grid of unit vectors to stereographic coordinates with "
      "fit error " +
      FormatModelFit(fit));
  return lens;
}

ExchangeContents ReadPuzzlepaint(const ReadRequest& request) {
  const YAML::Node root = LoadForeignMap(request.path, request.text);
  ExchangeContents contents;
  InputCamera& camera = contents.cameras.emplace_back();
  ReadCameraState(request, &camera, &contents.warnings);
  camera.lens = ReadPuzzlepaintIntrinsics(root, &contents.warnings);
  return contents;
}

// ---- Writing ---------------------------------------------------------------

std::string FormatVectors(const std::string& name,
                          const std::vector<Eigen::Vector3d>& vectors) {
  std::string text;
  for (const Eigen::Vector3d& vector : vectors)
    text += fmt::format("{}{}, {}, {}", text.empty() ? "" : ", ", vector.x(),
                        vector.y(), vector.z());
  return fmt::format("{} : [{}]\n", name, text);
}

std::string WritePuzzlepaint(const WriteRequest& request) {
  const OutputCamera& camera = request.cameras.front();
  const auto& grid = dynamic_cast<const UnitGrid&>(*camera.lens.grid);
  const UnitGrid::Bounds& bounds = grid.bounds();
  std::string text;
  for (const auto& [what, words] :
       {std::pair("camera", camera.name), std::pair("serial", camera.serial)})
    if (!words.empty())
      text += fmt::format("# raygrid's {} {}\n", what, Printable(words));
  if (camera.fit)
    text += fmt::format("# Fitted {}: {}\n", camera.lens.external_model->name,
                        FormatModelFit(*camera.fit));
  text += fmt::format(
      "type : {}\nwidth : {}\nheight : {}\n{} : {}\ncalibration_min_y : {}\n"
      "calibration_max_x : {}\ncalibration_max_y : {}\ngrid_width : {}\n"
      "grid_height : {}\n# Rows from top to bottom, each from left to right, "
      "of x, y, z.\n",
      camera.lens.external_model->name, grid.image_size().width,
      grid.image_size().height, kFirstX, bounds.min_x, bounds.min_y,
      bounds.max_x, bounds.max_y, grid.columns(), grid.rows());
  if (grid.IsCentral()) return text + FormatVectors("grid", grid.directions());
  return text + FormatVectors("point_grid", grid.points()) +
         FormatVectors("direction_grid", grid.directions());
}

// ---- Writing a state -------------------------------------------------------

std::vector<CompanionFile> WriteSingleCameraState(const WriteRequest& request) {
  if (request.cameras.front().poses.empty()) return {};
  if (ParseCameraFileIndex(request.path) != 0)
    throw Error(ExitCode::kUsage,
                fmt::format("-o {}: with --poses the camera file must be named "
                            "intrinsics0.yaml",
                            request.path));
  return WriteState(request.path, request.cameras, request.beside);
}

// Sorts cameras by number, which is the order of their names, as in
// dataset.bin.
std::vector<OutputCamera> SortCameras(std::vector<OutputCamera> cameras) {
  std::stable_sort(cameras.begin(), cameras.end(),
                   [](const OutputCamera& a, const OutputCamera& b) {
                     return a.name < b.name;
                   });
  return cameras;
}

std::vector<CompanionFile> WriteRigState(const WriteRequest& request) {
  const std::vector<OutputCamera> cameras = SortCameras(request.cameras);
  std::vector<CompanionFile> files;
  for (const OutputCamera& camera : cameras) {
    const std::string path =
        MakeStateFilePath(request.path, static_cast<int>(files.size()));
    files.push_back({path, WritePuzzlepaint({path, {camera}, {}})});
  }
  for (CompanionFile& file :
       WriteState(MakeStateFilePath(request.path, 0), cameras, request.beside))
    files.push_back(std::move(file));
  return files;
}

}  // namespace

Format MakePuzzlepaintFormat() {
  Format format;
  format.name = "puzzlepaint";
  format.holds =
      "intrinsics0.yaml of puzzlepaint's camera_calibration: central and "
      "noncentral generic models; a rig as a state folder with "
      "camera_tr_rig.yaml; poses of a board as rig_tr_global.yaml";
  format.external_models = GetPuzzlepaintModels();
  format.supports_poses = true;
  format.recognizes = [](const std::string& text) {
    return text.find(kFirstX) != std::string::npos;
  };
  format.read = ReadPuzzlepaint;
  format.write = WritePuzzlepaint;
  format.beside = ListStateFiles;
  format.write_beside = WriteSingleCameraState;
  format.file_in_folder = MakeStateFilePath;
  format.write_folder = WriteRigState;
  return format;
}

}  // namespace raygrid
