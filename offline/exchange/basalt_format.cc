#include "exchange/basalt_format.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <array>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/camera_keys.h"
#include "exchange/opencv_model_list.h"
#include "exchange/raygrid_json.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kRoot[] = "value0";  // cereal's name of the first value
constexpr char kPoses[] = "T_imu_cam";
constexpr char kIntrinsics[] = "intrinsics";
constexpr char kSizes[] = "resolution";
constexpr char kType[] = "camera_type";
constexpr char kRadius[] = "rpmax";  // key in pinhole-radtan8; 0: unlimited

// Parameter names are Basalt's JSON keys.
const std::vector<ExternalModel>& GetBasaltModels() {
  static const std::vector<ExternalModel> external_models = [] {
    ExternalModel fisheye = MakeOpenCvFisheyeModel("kb4");
    fisheye.max_supported_angle_rad = M_PI;
    return std::vector<ExternalModel>{
        MakeOpenCvModel("pinhole", 0),
        MakeOpenCvModel("pinhole-radtan8", 8),
        fisheye,
        MakeExternalModel("ds", models::kDoubleSphere, {"xi", "alpha"}),
        MakeExternalModel("eucm", models::kEucm, {"alpha", "beta"}),
        MakeExternalModel("ucm", models::kDoubleSphere, {"alpha"})};
  }();
  return external_models;
}

// Mandatory keys that raygrid does not estimate, nearly all of them IMU
// parameters. The values are the initial values of Basalt's calibration.
const Json& GetDefaultParameters() {
  static const Json defaults = {
      {"calib_accel_bias", std::vector<double>(9, 0)},
      {"calib_gyro_bias", std::vector<double>(12, 0)},
      {"imu_update_rate", 200.0},
      {"accel_noise_std", std::vector<double>(3, 0.016)},
      {"gyro_noise_std", std::vector<double>(3, 0.000282)},
      {"accel_bias_std", std::vector<double>(3, 0.001)},
      {"gyro_bias_std", std::vector<double>(3, 0.0001)},
      {"cam_time_offset_ns", 0},
      {"vignette", Json::array()}};
  return defaults;
}

// ---- Reading ---------------------------------------------------------------

const ExternalModel& FindBasaltModel(const std::string& type) {
  std::string names;
  for (const ExternalModel& external_model : GetBasaltModels()) {
    if (external_model.name == type) return external_model;
    names += (names.empty() ? "" : ", ") + external_model.name;
  }
  throw InputError(fmt::format("unsupported {} '{}'; supported are {}", kType,
                               Printable(type), names));
}

ConvertedCamera ReadBasaltCamera(const YAML::Node& camera,
                                 std::vector<std::string>* warnings) {
  if (!camera.IsMap() || !camera[kType] || !camera[kType].IsScalar())
    throw InputError(fmt::format("'{}' is missing", kType));
  ConvertedCamera lens;
  lens.external_model = &FindBasaltModel(camera[kType].as<std::string>());
  const YAML::Node values = camera[kIntrinsics];
  if (!values || !values.IsMap())
    throw InputError(fmt::format("'{}' is missing", kIntrinsics));
  const CameraKeys keys(values, kIntrinsics);
  for (const std::string& parameter : lens.external_model->parameters)
    lens.values.push_back(FiniteNumber(keys[parameter], parameter));
  keys.Skip({kRadius});
  keys.Finish(*lens.external_model, warnings);
  return lens;
}

Pose ReadBasaltPose(const YAML::Node& node) {
  if (!node.IsMap()) throw InputError("expected a pose");
  std::array<double, 7> numbers;
  const std::array<const char*, 7> keys = {"qw", "qx", "qy", "qz",
                                           "px", "py", "pz"};
  for (size_t k = 0; k < keys.size(); ++k)
    numbers[k] = FiniteNumber(node[keys[k]], keys[k]);
  return PoseFromQuaternion(numbers);
}

// Returns one entry per camera; empty if the list is missing.
std::vector<YAML::Node> ReadList(const YAML::Node& root,
                                 const std::string& name, size_t num_cameras) {
  const YAML::Node list = root[name];
  if (!list) return {};
  if (!list.IsSequence() || list.size() != num_cameras)
    throw InputError(
        fmt::format("{}: expected a list of {} entries, one per camera", name,
                    num_cameras));
  return {list.begin(), list.end()};
}

template <typename Read>
auto ReadEntry(const std::string& list, size_t index, const Read& read) {
  try {
    return read();
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}[{}]: {}", list, index, error.what()));
  }
}

// Assigns the names that raygrid wrote. Without names, cameras are numbered,
// and a single camera remains unnamed.
void NameBasaltCameras(const YAML::Node& file,
                       std::vector<InputCamera>* cameras) {
  const auto own = ReadList(file, kRaygridKey, cameras->size());
  for (size_t c = 0; c < cameras->size(); ++c) {
    InputCamera& camera = (*cameras)[c];
    if (!own.empty()) ParseRaygridJson(own[c], &camera);
    if (camera.name.empty() && cameras->size() > 1)
      camera.name = fmt::format("cam{}", c);
  }
}

// Whether a value equals the default that raygrid writes.
bool IsDefault(const std::string& key, const YAML::Node& value) {
  const auto found = GetDefaultParameters().find(key);
  if (found == GetDefaultParameters().end()) return false;
  if (!found->is_array())
    return value.IsScalar() && FiniteNumber(value, key) == found->get<double>();
  return value.IsSequence() &&
         (value.size() == 0
              ? found->empty()
              : value[0].IsScalar() && FiniteNumbers(value, key) ==
                                           found->get<std::vector<double>>());
}

void AddOtherWarnings(const YAML::Node& root, ExchangeContents* contents) {
  std::string others;
  for (const auto& entry : root) {
    const std::string key = entry.first.as<std::string>();
    if (key != kPoses && key != kIntrinsics && key != kSizes &&
        !IsDefault(key, entry.second))
      others += (others.empty() ? "" : ", ") + Printable(key);
  }
  if (!others.empty()) contents->warnings.push_back("ignored: " + others);
  for (const YAML::Node& camera : root[kIntrinsics]) {
    const YAML::Node radius = camera[kIntrinsics][kRadius];
    if (!radius || FiniteNumber(radius, kRadius) == 0) continue;
    contents->warnings.push_back(fmt::format(
        "ignored: {} (the calibrated area ends where the distortion folds)",
        kRadius));
    break;
  }
}

ExchangeContents ReadBasalt(const ReadRequest& request) {
  const YAML::Node file = LoadForeignMap(request.path, request.text);
  const YAML::Node root = file[kRoot];
  if (!root || !root.IsMap() || !root[kIntrinsics] ||
      !root[kIntrinsics].IsSequence())
    throw InputError(fmt::format("not a calibration: {} has no list '{}'",
                                 kRoot, kIntrinsics));
  const size_t count = root[kIntrinsics].size();
  const auto sizes = ReadList(root, kSizes, count);
  const auto poses = ReadList(root, kPoses, count);
  ExchangeContents contents;
  Pose imu_from_first;
  for (size_t c = 0; c < count; ++c) {
    InputCamera camera;
    camera.lens = ReadEntry(kIntrinsics, c, [&] {
      return ReadBasaltCamera(root[kIntrinsics][c], &contents.warnings);
    });
    if (!sizes.empty()) camera.lens.size = GetListSize(sizes[c], kSizes);
    if (!poses.empty()) {
      const Pose imu_from_camera =
          ReadEntry(kPoses, c, [&] { return ReadBasaltPose(poses[c]); });
      if (c == 0) imu_from_first = imu_from_camera;
      camera.camera_from_rig =
          c == 0 ? Pose{} : imu_from_camera.Inverse() * imu_from_first;
    }
    contents.cameras.push_back(std::move(camera));
  }
  NameBasaltCameras(file, &contents.cameras);
  AddOtherWarnings(root, &contents);
  if (imu_from_first.translation.norm() + imu_from_first.rotation.vec().norm() >
      0)
    contents.warnings.push_back(
        fmt::format("ignoring the IMU frame of {}: poses are relative to the "
                    "first camera",
                    kPoses));
  if (poses.empty() && count > 1)
    contents.warnings.push_back(
        fmt::format("no {}: importing cameras without relative poses", kPoses));
  return contents;
}

bool IsBasalt(const std::string& text) {
  for (const char* word : {"\"value0\"", "\"camera_type\""})
    if (text.find(word) == std::string::npos) return false;
  return true;
}

// ---- Writing ---------------------------------------------------------------

Json BasaltPose(const Pose& pose) {
  // Adding 0 turns -0 into 0.
  const Eigen::Vector4d q = pose.rotation.coeffs().array() + 0.0;
  const Eigen::Vector3d t = pose.translation.array() + 0.0;
  return {{"px", t.x()}, {"py", t.y()}, {"pz", t.z()}, {"qx", q.x()},
          {"qy", q.y()}, {"qz", q.z()}, {"qw", q.w()}};
}

Json MakeBasaltIntrinsics(const ConvertedCamera& lens) {
  Json values = Json::object();
  for (size_t k = 0; k < lens.values.size(); ++k)
    values[lens.external_model->parameters[k]] = lens.values[k];
  if (lens.external_model->Has("k6")) values[kRadius] = 0.0;
  return {{kType, lens.external_model->name}, {kIntrinsics, std::move(values)}};
}

// The IMU frame is the rig frame, or the camera frame of a single camera.
// Basalt ignores keys after its own root value.
std::string WriteBasalt(const WriteRequest& request) {
  Json root = {{kPoses, Json::array()},
               {kIntrinsics, Json::array()},
               {kSizes, Json::array()}};
  Json own = Json::array();
  for (const OutputCamera& camera : request.cameras) {
    const ConvertedCamera& lens = camera.lens;
    root[kPoses].push_back(
        BasaltPose(camera.camera_from_rig.value_or(Pose{}).Inverse()));
    root[kIntrinsics].push_back(MakeBasaltIntrinsics(lens));
    root[kSizes].push_back({lens.size.width, lens.size.height});
    own.push_back(MakeRaygridJson(camera));
  }
  root.update(GetDefaultParameters());
  return Json{{kRoot, std::move(root)}, {kRaygridKey, std::move(own)}}.dump(4) +
         "\n";
}

}  // namespace

Format MakeBasaltFormat() {
  Format format;
  format.name = "basalt";
  format.holds =
      "calibration.json: a camera or rig of pinhole, radtan8, kb4, ds, eucm "
      "and ucm cameras";
  format.external_models = GetBasaltModels();
  format.ending = ".json";
  format.supports_rigs = true;
  format.recognizes = IsBasalt;
  format.read = ReadBasalt;
  format.write = WriteBasalt;
  return format;
}

}  // namespace raygrid
