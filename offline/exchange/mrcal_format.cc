#include "exchange/mrcal_format.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <regex>

#include "camera/splined_stereographic.h"
#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/camera_keys.h"
#include "exchange/opencv_model_list.h"
#include "exchange/photonvision_format.h"
#include "exchange/valid_region.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kPrefix[] = "LENSMODEL_";
constexpr char kSplined[] = "LENSMODEL_SPLINED_STEREOGRAPHIC";

const std::vector<ExternalModel>& GetMrcalModels() {
  static const std::vector<ExternalModel> external_models = {
      MakeOpenCvModel("LENSMODEL_PINHOLE", 0),
      MakeOpenCvModel("LENSMODEL_OPENCV4", 4),
      MakeOpenCvModel("LENSMODEL_OPENCV5", 5),
      MakeOpenCvModel("LENSMODEL_OPENCV8", 8),
      MakeOpenCvModel("LENSMODEL_OPENCV12", 12),
      {kSplined, models::kSplinedStereographic, {"fx", "fy", "cx", "cy"}}};
  return external_models;
}

// ---- The dictionary as YAML ------------------------------------------------

// Returns the index after the string whose opening quote is at an index.
size_t BehindString(const std::string& text, size_t quote) {
  size_t end = quote + 1;
  while (end < text.size() && text[end] != text[quote])
    end += text[end] == '\\' ? 2 : 1;
  return std::min(end + 1, text.size());
}

// Converts a Python dictionary to YAML: removes comments, converts tuples to
// lists, and empties byte strings, which are long and contain the solver's
// inputs.
std::string ConvertToYaml(const std::string& text) {
  std::string yaml;
  for (size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
    } else if (c == '\'' || c == '"') {
      const size_t end = BehindString(text, at);
      const bool is_bytes = !yaml.empty() && yaml.back() == 'b';
      if (is_bytes) yaml.back() = ' ';
      yaml += is_bytes ? "''" : text.substr(at, end - at);
      at = end;
      if (at < text.size() && text[at] == ':') yaml += " ";
    } else {
      yaml += c == '(' ? '[' : c == ')' ? ']' : c;
      ++at;
      if (c == ':') yaml += ' ';
    }
  }
  return yaml;
}

// ---- Reading ---------------------------------------------------------------

const ExternalModel& FindMrcalModel(const std::string& name) {
  std::string names;
  for (const ExternalModel& external_model : GetMrcalModels()) {
    if (external_model.name == name) return external_model;
    names += (names.empty() ? "" : ", ") + external_model.name;
  }
  throw InputError(fmt::format("unsupported lensmodel '{}'; supported are {}",
                               Printable(name), names));
}

// Parses the grid from a name such as
// LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=30_Ny=20_fov_x_deg=170.
SplinedStereographic::Grid ParseGrid(const std::string& name) {
  static const std::regex words(
      std::string(kSplined) +
      "_order=([0-9]{1,4})_Nx=([0-9]{1,4})_Ny=([0-9]{1,4})_"
      "fov_x_deg=([0-9]{1,4})");
  std::smatch found;
  if (!std::regex_match(name, found, words))
    throw InputError(
        fmt::format("lensmodel '{}': expected the form "
                    "{}_order=3_Nx=30_Ny=20_fov_x_deg=170",
                    Printable(name), kSplined));
  if (std::stoi(found[1]) != 3)
    throw InputError("lensmodel: only splines of order 3 are supported");
  const SplinedStereographic::Grid grid = {
      std::stoi(found[2]), std::stoi(found[3]), std::stoi(found[4])};
  constexpr int kMost = 1027;
  if (std::min(grid.columns, grid.rows) < 4 ||
      std::max(grid.columns, grid.rows) > kMost)
    throw InputError("lensmodel: Nx and Ny must be 4 to 1027");
  if (grid.fov_x_deg < 1 || grid.fov_x_deg > 359)
    throw InputError("lensmodel: fov_x_deg must be 1 to 359");
  return grid;
}

// mrcal stores fx, fy, cx, cy before the control points.
std::shared_ptr<const SplinedStereographic> MakeSpline(
    const std::string& name, const ImageSize& size,
    const std::vector<double>& intrinsics) {
  const SplinedStereographic::Grid grid = ParseGrid(name);
  const int count = 2 * grid.columns * grid.rows;
  if (static_cast<int>(intrinsics.size()) != 4 + count)
    throw InputError(fmt::format("intrinsics: expected {} numbers, found {}",
                                 4 + count, intrinsics.size()));
  const Eigen::Map<const Eigen::VectorXd> all(intrinsics.data(), 4 + count);
  Eigen::VectorXd parameters(4 + count);
  parameters << all.tail(count), all.head<4>();
  return std::make_shared<SplinedStereographic>(size, WholeImage(size), grid,
                                                parameters);
}

// mrcal before version 1 calls models DISTORTION_..., and the pinhole model
// DISTORTION_NONE.
std::string ReadModelName(const CameraKeys& root) {
  constexpr char kOldKey[] = "distortion_model", kOldPrefix[] = "DISTORTION_";
  const bool is_old = !root.Has("lensmodel") && root.Has(kOldKey);
  const char* const key = is_old ? kOldKey : "lensmodel";
  const YAML::Node node = root[key];
  if (!node.IsDefined() || !node.IsScalar())
    throw InputError("'lensmodel' is missing");
  const std::string name = node.as<std::string>();
  if (name.rfind(kOldPrefix, 0) != 0) return name;
  const std::string behind = name.substr(sizeof kOldPrefix - 1);
  return kPrefix + (behind == "NONE" ? "PINHOLE" : behind);
}

ConvertedCamera ReadCameraModel(const CameraKeys& root) {
  const std::string name = ReadModelName(root);
  const bool is_spline = name.rfind(kSplined, 0) == 0;
  ConvertedCamera lens;
  lens.external_model = &FindMrcalModel(is_spline ? kSplined : name);
  const char* const size_key =
      root.Has("imagersize") ? "imagersize" : "dimensions";
  if (!root.Has(size_key)) throw InputError("'imagersize' is missing");
  lens.size = GetListSize(root[size_key], size_key);
  lens.values = FiniteNumbers(root["intrinsics"], "intrinsics");
  if (is_spline) {
    lens.spline = MakeSpline(name, lens.size, lens.values);
    lens.values.clear();
  }
  return lens;
}

// Since version 2.5, the key of the pose states its direction: rt_cam_ref.
std::optional<Pose> ReadMrcalPose(const CameraKeys& root) {
  const char* const key = root.Has("rt_cam_ref") ? "rt_cam_ref" : "extrinsics";
  if (!root.Has(key)) return std::nullopt;
  const std::vector<double> rt = FiniteNumbers(root[key], key, 6);
  return Pose{RotationFromVector({rt[0], rt[1], rt[2]}), {rt[3], rt[4], rt[5]}};
}

// nullopt if the file has no region, i.e. the valid region is unknown.
std::optional<ValidityMask> ParseValidRegion(const CameraKeys& root,
                                             const ImageSize& size) {
  constexpr char kKey[] = "valid_intrinsics_region";
  const YAML::Node node = root[kKey];
  if (!node.IsDefined() || node.IsNull()) return std::nullopt;
  if (!node.IsSequence())
    throw InputError(fmt::format("{}: expected a list of points", kKey));
  ValidRegion region;
  for (const YAML::Node& point : node) {
    const std::vector<double> xy = FiniteNumbers(point, kKey, 2);
    region.emplace_back(xy[0], xy[1]);
  }
  if (!region.empty() && region.size() < 3)
    throw InputError(fmt::format("{}: fewer than 3 points", kKey));
  return MakeValidityMask(region, size);
}

ExchangeContents ReadMrcal(const ReadRequest& request) {
  const std::string yaml = ConvertToYaml(request.text);
  const CameraKeys root(LoadForeignMap(request.path, yaml));
  ExchangeContents contents;
  InputCamera camera;
  camera.lens = ReadCameraModel(root);
  camera.camera_from_rig = ReadMrcalPose(root);
  camera.valid_region = ParseValidRegion(root, camera.lens.size);
  root.Skip({"rt_cam_ref", "extrinsics", "icam_intrinsics",
             "icam_intrinsics_optimization_inputs", "optimization_inputs",
             "observed_pixel_uncertainty", "invJtJ_intrinsics_full",
             "invJtJ_intrinsics_observations_only", "covariance_intrinsics*"});
  root.Finish(*camera.lens.external_model, &contents.warnings);
  contents.cameras.push_back(std::move(camera));
  return contents;
}

// ---- Writing ---------------------------------------------------------------

// Returns the name of a camera's model and its parameters in mrcal's order.
std::pair<std::string, std::vector<double>> GetNameAndValues(
    const ConvertedCamera& lens) {
  if (!lens.spline) return {lens.external_model->name, lens.values};
  const SplinedStereographic::Grid& grid = lens.spline->grid();
  const Eigen::VectorXd parameters = lens.spline->Parameters();
  std::vector<double> values(parameters.end() - 4, parameters.end());
  values.insert(values.end(), parameters.begin(), parameters.end() - 4);
  return {fmt::format("{}_order=3_Nx={}_Ny={}_fov_x_deg={}", kSplined,
                      grid.columns, grid.rows, grid.fov_x_deg),
          values};
}

// Formats a one-line comment.
std::string Comment(const std::string& what, const std::string& text) {
  return text.empty() ? "" : fmt::format("# {}{}\n", what, Printable(text));
}

std::string FormatRegion(const ValidityMask& valid_region,
                         const ImageSize& size) {
  std::string text = "    'valid_intrinsics_region': [\n";
  for (const Eigen::Vector2d& point : ComputeValidRegion(valid_region, size))
    text += fmt::format("    [ {}, {} ],\n", point.x(), point.y());
  return text + "],\n\n";
}

// For a camera that is not in a rig, the reference frame is the camera frame.
std::string WriteMrcal(const WriteRequest& request) {
  const OutputCamera& camera = request.cameras.front();
  const auto [model, values] = GetNameAndValues(camera.lens);
  Pose pose = camera.camera_from_rig.value_or(Pose{});
  if (!camera.camera_from_rig && camera.fit)
    pose.rotation = camera.fit->fitted_from_camera;
  const Eigen::AngleAxisd turn(pose.rotation);
  const Eigen::Vector3d r = turn.angle() * turn.axis(), t = pose.translation;
  const std::string rt = RealTexts({r.x(), r.y(), r.z(), t.x(), t.y(), t.z()});
  std::string text = Comment("raygrid camera ", camera.name);
  text += Comment("serial ", camera.serial);
  if (camera.fit) text += Comment("fit: ", FormatModelFit(*camera.fit));
  text += fmt::format("{{\n    'lensmodel': '{}',\n\n", model);
  text += fmt::format("    'intrinsics': [ {},],\n\n", RealTexts(values));
  if (camera.valid_region)
    text += FormatRegion(*camera.valid_region, camera.lens.size);
  text += fmt::format("    # rt_cam_ref\n    'extrinsics': [ {},],\n\n", rt);
  text += fmt::format("    'imagersize': [ {}, {},],\n}}\n",
                      camera.lens.size.width, camera.lens.size.height);
  return text;
}

bool IsMrcal(const std::string& text) {
  if (IsPhotonVision(text)) return false;
  for (const char* key : {"'lensmodel'", "\"lensmodel\""})
    if (text.find(key) != std::string::npos) return true;
  return (text.find(kPrefix) != std::string::npos ||
          text.find("DISTORTION_") != std::string::npos) &&
         (text.find("'intrinsics'") != std::string::npos ||
          text.find("\"intrinsics\"") != std::string::npos);
}

}  // namespace

Format MakeMrcalFormat() {
  Format format;
  format.name = "mrcal";
  format.holds =
      ".cameramodel: pinhole with 4, 5, 8 or 12 OpenCV coefficients, or the "
      "splined stereographic model; one file per camera of a rig";
  format.external_models = GetMrcalModels();
  format.ending = ".cameramodel";
  format.supports_region = true;
  format.recognizes = IsMrcal;
  format.read = ReadMrcal;
  format.write = WriteMrcal;
  return format;
}

}  // namespace raygrid
