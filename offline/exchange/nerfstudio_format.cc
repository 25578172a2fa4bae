#include "exchange/nerfstudio_format.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/camera_keys.h"
#include "exchange/keyed_table.h"
#include "exchange/raygrid_json.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kNerfModel[] = "camera_model";
constexpr char kFrames[] = "frames";
constexpr char kFramePosition[] = "transform_matrix";
constexpr char kNerfFisheye[] = "OPENCV_FISHEYE";
constexpr char kNgpFisheye[] = "is_fisheye";

constexpr std::array<std::pair<const char*, const char*>, 4> kIntrinsics = {
    {{"fx", "fl_x"}, {"fy", "fl_y"}, {"cx", "cx"}, {"cy", "cy"}}};
// In the order of nerfstudio's distortion_params.
constexpr std::array<const char*, 6> kCoefficients = {"k1", "k2", "k3",
                                                      "k4", "p1", "p2"};

// nerfstudio samples pixels at their centres, the first of which is at (0.5,
// 0.5): get_image_coords(pixel_offset=0.5). Its fisheye rays are not normalized
// by z.
const std::vector<ExternalModel>& GetNerfstudioModels() {
  static const std::vector<ExternalModel> external_models = [] {
    std::vector<ExternalModel> made = {
        MakeExternalModel("PINHOLE", models::kOpenCv, {}),
        MakeExternalModel("OPENCV", models::kOpenCv,
                          {"k1", "k2", "k3", "p1", "p2"}),
        MakeExternalModel(kNerfFisheye, models::kThinPrismFisheye,
                          {"k1", "k2", "k3", "k4"})};
    for (ExternalModel& external_model : made) {
      external_model.origin = PixelOrigin::kImageCorner;
      external_model.max_supported_angle_rad =
          external_model.name == kNerfFisheye ? M_PI : M_PI / 2;
    }
    return made;
  }();
  return external_models;
}

// Converts between OpenCV's camera axes and OpenGL's: view direction -z, y up.
Pose Rotated(const Pose& world_from_camera) {
  return world_from_camera *
         Pose{Eigen::Quaterniond(0, 1, 0, 0), Eigen::Vector3d::Zero()};
}

// ---- Reading ---------------------------------------------------------------

// Keys of instant-ngp's and nerfstudio's scenes that are not intrinsics.
const std::vector<std::string> kSceneKeys = [] {
  std::vector<std::string> keys = SplitText(
      "aabb_scale camera_angle_x camera_angle_y scale offset up "
      "applied_transform applied_scale ply_file_path train_filenames "
      "val_filenames test_filenames n_extra_learnable_dims "
      "enable_depth_loading integer_depth_scale orientation_override "
      "auto_scale_poses_override from_na render_aabb file_path sharpness "
      "mask_path depth_file_path depth_path colmap_im_id fisheye_crop_radius");
  keys.insert(keys.end(), {kFrames, kFramePosition, kRaygridKey});
  return keys;
}();

// Returns the mapping with the intrinsics: the file, or its first frame if all
// frames have the same ones.
YAML::Node MakeCameraNode(const YAML::Node& root) {
  if (root["fl_x"]) return root;
  const YAML::Node frames = root[kFrames];
  if (!frames || !frames.IsSequence() || frames.size() == 0 ||
      !frames[0].IsMap() || !frames[0]["fl_x"])
    throw InputError("contains no camera: 'fl_x' is missing");
  for (const char* key :
       {"fl_x", "fl_y", "cx", "cy", "w", "h", "k1", "k2", "k3", "k4", "p1",
        "p2", "distortion_params", kNerfModel, kNgpFisheye})
    for (size_t k = 1; k < frames.size(); ++k)
      if (YAML::Dump(frames[k][key]) != YAML::Dump(frames[0][key]))
        throw InputError(
            fmt::format("frames[{}]: {} differs from frames[0]; only files of "
                        "a single camera are supported",
                        k, key));
  return frames[0];
}

// In the order of kCoefficients; missing ones are 0.
std::vector<double> ReadCoefficients(const CameraKeys& camera) {
  constexpr char kList[] = "distortion_params";
  if (camera.Has(kList))
    return FiniteNumbers(camera[kList], kList, kCoefficients.size());
  std::vector<double> numbers;
  for (const char* key : kCoefficients)
    numbers.push_back(camera.Has(key) ? FiniteNumber(camera[key], key) : 0);
  return numbers;
}

// instant-ngp uses a flag instead of a model name.
std::string ReadNerfstudioModelName(const CameraKeys& camera,
                                    const YAML::Node& root) {
  const YAML::Node flag = camera[kNgpFisheye];
  bool is_fisheye = false;
  if (flag.IsDefined() && !YAML::convert<bool>::decode(flag, is_fisheye) &&
      camera.Word(kNgpFisheye) != "0")
    is_fisheye = true;
  std::string model = camera[kNerfModel].IsDefined() ? camera.Word(kNerfModel)
                      : root[kNerfModel] ? root[kNerfModel].as<std::string>()
                                         : "";
  if (is_fisheye && !model.empty() && model != kNerfFisheye)
    throw InputError(fmt::format("'{}' indicates a fisheye, but '{}' is {}",
                                 kNgpFisheye, kNerfModel, Printable(model)));
  if (is_fisheye) return kNerfFisheye;
  return model.empty() ? "OPENCV" : model;
}

// Throws for non-zero coefficients that nerfstudio applies to rays, but ignores
// in undistortion.
void RequireZero(const std::vector<double>& coefficients,
                 std::initializer_list<size_t> indices,
                 const std::string& model) {
  for (const size_t k : indices)
    if (coefficients[k] != 0)
      throw InputError(
          fmt::format("{} of {} must be 0: nerfstudio uses it for rays, but "
                      "not for undistortion",
                      kCoefficients[k], model));
}

const ExternalModel& FindNerfstudioModel(
    const std::string& model, const std::vector<double>& coefficients) {
  const std::vector<ExternalModel>& external_models = GetNerfstudioModels();
  if (model == kNerfFisheye) {
    RequireZero(coefficients, {4, 5}, model);
    return external_models[2];
  }
  for (const char* pinhole :
       {"SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV"}) {
    if (model != pinhole) continue;
    RequireZero(coefficients, {3}, model);
    const bool is_plain =
        std::count(coefficients.begin(), coefficients.end(), 0) ==
        static_cast<std::ptrdiff_t>(coefficients.size());
    return external_models[is_plain ? 0 : 1];
  }
  throw InputError(
      fmt::format("unsupported {} '{}'; supported are PINHOLE, OPENCV and {}",
                  kNerfModel, Printable(model), kNerfFisheye));
}

ConvertedCamera ReadNerfstudioIntrinsics(const YAML::Node& root,
                                         std::vector<std::string>* warnings) {
  const CameraKeys camera(MakeCameraNode(root));
  const std::vector<double> coefficients = ReadCoefficients(camera);
  ConvertedCamera lens;
  lens.external_model =
      &FindNerfstudioModel(ReadNerfstudioModelName(camera, root), coefficients);
  if (camera.Has("w") || camera.Has("h"))
    lens.size = {SidePx(camera["w"], "w"), SidePx(camera["h"], "h")};
  for (const auto& [parameter, key] : kIntrinsics)
    lens.values.push_back(FiniteNumber(camera[key], key));
  for (size_t k = 0; k < kCoefficients.size(); ++k)
    if (lens.external_model->Has(kCoefficients[k]))
      lens.values.push_back(coefficients[k]);
  camera.Skip(kSceneKeys);
  camera.Finish(*lens.external_model, warnings);
  return lens;
}

// The world frame is a target's frame.
BoardPose ReadFrame(const YAML::Node& frame) {
  if (!frame.IsMap() || !frame["file_path"])
    throw InputError("'file_path' is missing");
  const YAML::Node rows = frame[kFramePosition];
  if (!rows || !rows.IsSequence() || rows.size() < 3)
    throw InputError(fmt::format("{}: not 4 x 4", kFramePosition));
  std::vector<double> numbers;
  for (size_t row = 0; row < 3; ++row)
    for (const double number : FiniteNumbers(rows[row], kFramePosition, 4))
      numbers.push_back(number);
  return {frame["file_path"].as<std::string>(), 0,
          Rotated(PoseFromMatrix(numbers, kFramePosition)).Inverse()};
}

void ReadFrames(const YAML::Node& frames, ExchangeContents* contents) {
  if (!frames || !frames.IsSequence()) return;
  std::vector<BoardPose> poses;
  for (size_t k = 0; k < frames.size(); ++k) {
    try {
      poses.push_back(ReadFrame(frames[k]));
    } catch (const InputError& error) {
      contents->warnings.push_back(fmt::format(
          "frame poses are ignored: frames[{}]: {}", k, error.what()));
      return;
    }
  }
  contents->cameras.front().poses = std::move(poses);
}

ExchangeContents ReadNerfstudio(const ReadRequest& request) {
  const YAML::Node root = LoadForeignMap(request.path, request.text);
  ExchangeContents contents;
  InputCamera camera;
  camera.lens = ReadNerfstudioIntrinsics(root, &contents.warnings);
  ParseRaygridJson(root[kRaygridKey], &camera);
  contents.cameras.push_back(std::move(camera));
  if (root["fisheye_crop_radius"])
    contents.warnings.push_back("ignored: fisheye_crop_radius");
  ReadFrames(root[kFrames], &contents);
  return contents;
}

bool IsNerfstudio(const std::string& text) {
  return text.find("\"fl_x\"") != std::string::npos;
}

// ---- Writing ---------------------------------------------------------------

Json MakeFrameJson(const BoardPose& pose) {
  const Pose place = Rotated(pose.camera_from_board.Inverse());
  const Eigen::Matrix3d r = place.rotation.toRotationMatrix();
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row)
    rows.push_back(
        {r(row, 0), r(row, 1), r(row, 2), place.translation[row] + 0.0});
  rows.push_back({0.0, 0.0, 0.0, 1.0});
  return {{"file_path", Printable(pose.image)},
          {kFramePosition, std::move(rows)}};
}

std::string WriteNerfstudio(const WriteRequest& request) {
  const OutputCamera& camera = request.cameras.front();
  const ConvertedCamera& lens = camera.lens;
  RequireOneBoard("nerfstudio", request.cameras);
  Json root = {{kNerfModel, lens.external_model->name},
               {"w", lens.size.width},
               {"h", lens.size.height}};
  for (const auto& [parameter, key] : kIntrinsics)
    root[key] = lens.Value(parameter);
  for (const char* key : kCoefficients)
    root[key] = lens.external_model->Has(key) ? lens.Value(key) : 0.0;
  root[kRaygridKey] = MakeRaygridJson(camera);
  root[kFrames] = Json::array();
  for (const BoardPose& pose : camera.poses)
    root[kFrames].push_back(MakeFrameJson(pose));
  return root.dump(4) + "\n";
}

}  // namespace

Format MakeNerfstudioFormat() {
  Format format;
  format.name = "nerfstudio";
  format.holds =
      "transforms.json: pinhole with optional k1, k2, k3, p1, p2, or OpenCV "
      "fisheye; one file per camera of a rig; poses of a board as frames";
  format.external_models = GetNerfstudioModels();
  format.ending = ".json";
  format.supports_poses = true;
  format.discards_rig_poses = true;
  format.recognizes = IsNerfstudio;
  format.read = ReadNerfstudio;
  format.write = WriteNerfstudio;
  return format;
}

}  // namespace raygrid
