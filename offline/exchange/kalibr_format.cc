#include "exchange/kalibr_format.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <set>

#include "dataset/error.h"
#include "dataset/rig_file.h"
#include "dataset/text_encoding.h"
#include "exchange/camera_keys.h"
#include "exchange/opencv_model_list.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

// Makes a model with the parameters in the order of Kalibr's intrinsics and
// distortion coefficients. Its name is CAMERA-DISTORTION, as in
// kalibr_calibrate_cameras --models.
ExternalModel MakeKalibrModel(const std::string& name, const std::string& model,
                              std::vector<std::string> first,
                              const std::vector<std::string>& coefficients,
                              double max_supported_angle_rad) {
  ExternalModel external_model;
  external_model.name = name;
  external_model.model = model;
  external_model.parameters = std::move(first);
  for (const char* parameter : {"fx", "fy", "cx", "cy"})
    external_model.parameters.push_back(parameter);
  external_model.parameters.insert(external_model.parameters.end(),
                                   coefficients.begin(), coefficients.end());
  external_model.max_supported_angle_rad = max_supported_angle_rad;
  return external_model;
}

const std::vector<ExternalModel>& GetKalibrModels() {
  static const std::vector<ExternalModel> external_models = {
      MakeKalibrModel("pinhole-none", models::kOpenCv, {}, {}, M_PI / 2),
      MakeKalibrModel("pinhole-radtan", models::kOpenCv, {},
                      {"k1", "k2", "p1", "p2"}, M_PI / 2),
      MakeKalibrModel("pinhole-equi", models::kThinPrismFisheye, {},
                      {"k1", "k2", "k3", "k4"}, M_PI / 2),
      MakeKalibrModel("omni-none", models::kOmniRadtan, {"xi"}, {}, M_PI),
      MakeKalibrModel("omni-radtan", models::kOmniRadtan, {"xi"},
                      {"k1", "k2", "p1", "p2"}, M_PI),
      MakeKalibrModel("ds-none", models::kDoubleSphere, {"xi", "alpha"}, {},
                      M_PI),
      MakeKalibrModel("eucm-none", models::kEucm, {"alpha", "beta"}, {}, M_PI)};
  return external_models;
}

// Kalibr abbreviates equidistant to equi.
std::string GetKalibrDistortionModel(const ExternalModel& external_model) {
  const std::string distortion =
      external_model.name.substr(external_model.name.find('-') + 1);
  return distortion == "equi" ? "equidistant" : distortion;
}

std::string GetKalibrCameraModel(const ExternalModel& external_model) {
  return external_model.name.substr(0, external_model.name.find('-'));
}

const ExternalModel& FindKalibrModel(const std::string& camera,
                                     const std::string& distortion) {
  std::string names;
  for (const ExternalModel& external_model : GetKalibrModels()) {
    if (GetKalibrCameraModel(external_model) == camera &&
        GetKalibrDistortionModel(external_model) == distortion)
      return external_model;
    names += (names.empty() ? "" : ", ") + external_model.name;
  }
  throw InputError(
      fmt::format("unsupported camera_model '{}' with distortion_model '{}'; "
                  "supported are {}",
                  Printable(camera), Printable(distortion), names));
}

// ---- Reading ---------------------------------------------------------------

// Returns the second-last component of a topic: cam0 of /cam0/image_raw.
std::string GetCameraName(const YAML::Node& topic) {
  if (!topic.IsDefined() || !topic.IsScalar()) return "";
  const std::string text = topic.as<std::string>();
  const size_t last = text.rfind('/');
  if (last == std::string::npos || last == 0) return "";
  const size_t before = text.rfind('/', last - 1);
  const std::string name = text.substr(before + 1, last - before - 1);
  return IsRigCameraName(name) ? name : "";
}

// Cameras are named after their topics if these are complete and unique,
// otherwise after Kalibr's keys. A single camera numbered by Kalibr remains
// unnamed.
void NameCameras(const YAML::Node& root, std::vector<InputCamera>* cameras) {
  std::set<std::string> names;
  for (size_t c = 0; c < cameras->size(); ++c) {
    const std::string key = fmt::format("cam{}", c);
    (*cameras)[c].name = GetCameraName(root[key]["rostopic"]);
    names.insert((*cameras)[c].name);
  }
  if (cameras->size() == 1) {
    if (cameras->front().name == "cam0") cameras->front().name.clear();
  } else if (names.size() != cameras->size() || names.count("") > 0) {
    for (size_t c = 0; c < cameras->size(); ++c)
      (*cameras)[c].name = fmt::format("cam{}", c);
  }
}

// DSEC's key of the four intrinsics.
constexpr char kDsecIntrinsics[] = "camera_matrix";
constexpr char kDsecRectified[] = "camRect";

ConvertedCamera ReadKalibrIntrinsics(const CameraKeys& camera) {
  const auto get_text = [&](const char* key) {
    if (!camera.Has(key)) throw InputError(fmt::format("'{}' is missing", key));
    return camera[key].as<std::string>();
  };
  ConvertedCamera lens;
  lens.external_model =
      &FindKalibrModel(get_text("camera_model"), get_text("distortion_model"));
  if (camera.Has("resolution"))
    lens.size = GetListSize(camera["resolution"], "resolution");
  const char* const intrinsics =
      camera.Has("intrinsics") ? "intrinsics" : kDsecIntrinsics;
  lens.values = FiniteNumbers(camera[intrinsics], intrinsics);
  std::vector<double> coefficients;
  constexpr char kKey[] = "distortion_coeffs";
  constexpr size_t kNumCoefficients = 4;
  if (GetKalibrDistortionModel(*lens.external_model) != "none") {
    coefficients = FiniteNumbers(camera[kKey], kKey);
    TrimCoefficients(kNumCoefficients, &coefficients);
    if (coefficients.size() != kNumCoefficients)
      throw InputError(fmt::format("{}: expected a list of {} numbers", kKey,
                                   kNumCoefficients));
  } else if (camera.Has(kKey) && !camera[kKey].IsNull()) {
    coefficients = FiniteNumbers(camera[kKey], kKey);
    TrimCoefficients(0, &coefficients);
    if (!coefficients.empty())
      throw InputError(
          fmt::format("{}: must be zero with distortion_model none", kKey));
  }
  const size_t num_intrinsics =
      lens.external_model->parameters.size() - coefficients.size();
  if (lens.values.size() != num_intrinsics)
    throw InputError(fmt::format("intrinsics: found {} numbers, but {} has {}",
                                 lens.values.size(), lens.external_model->name,
                                 num_intrinsics));
  lens.values.insert(lens.values.end(), coefficients.begin(),
                     coefficients.end());
  return lens;
}

Pose ReadKalibrPose(const CameraKeys& camera, const char* name) {
  const std::vector<double> numbers = AllNumbers(camera[name], name);
  if (numbers.size() != 16)
    throw InputError(fmt::format("{}: not 4 x 4", name));
  return PoseFromMatrix(numbers, name);
}

// Returns the pose relative to the previous camera; nullopt if missing. Files
// of 2013 use the older key.
std::optional<Pose> PoseFromLast(const CameraKeys& camera) {
  for (const char* key : {"T_cn_cnm1", "baseline_last_to_this_cam"})
    if (camera.Has(key)) return ReadKalibrPose(camera, key);
  return std::nullopt;
}

// Returns the pose relative to the IMU; OpenVINS stores the inverse.
std::optional<Pose> PoseFromImu(const CameraKeys& camera) {
  if (camera.Has("T_cam_imu")) return ReadKalibrPose(camera, "T_cam_imu");
  if (camera.Has("T_imu_cam"))
    return ReadKalibrPose(camera, "T_imu_cam").Inverse();
  return std::nullopt;
}

ExchangeContents ReadKalibr(const ReadRequest& request) {
  YAML::Node root = LoadForeignMap(request.path, request.text);
  // DSEC stores the camera chain in a nested map next to the rectified cameras.
  if (const YAML::Node chain = root["intrinsics"];
      !root["cam0"] && chain && chain.IsMap())
    root.reset(YAML::Node(chain));
  if (!root["cam0"]) throw InputError("not a camchain: 'cam0' is missing");
  ExchangeContents contents;
  std::optional<Pose> first_from_imu;
  for (size_t c = 0; root[fmt::format("cam{}", c)]; ++c) {
    const std::string key = fmt::format("cam{}", c);
    try {
      const CameraKeys keys(root[key], key);
      InputCamera camera;
      camera.lens = ReadKalibrIntrinsics(keys);
      const std::optional<Pose> from_last = PoseFromLast(keys),
                                from_imu = PoseFromImu(keys);
      if (c == 0) {
        first_from_imu = from_imu;
        camera.camera_from_rig = Pose{};
      } else if (from_last && contents.cameras.back().camera_from_rig) {
        camera.camera_from_rig =
            *from_last * *contents.cameras.back().camera_from_rig;
      } else if (from_imu && first_from_imu) {
        camera.camera_from_rig = *from_imu * first_from_imu->Inverse();
      }
      keys.Skip({"T_cam_imu", "T_imu_cam", "timeshift_cam_imu", "cam_overlaps",
                 "rostopic", "camera_type", "camera_location", "is_rectified"});
      keys.Finish(*camera.lens.external_model, &contents.warnings);
      contents.cameras.push_back(std::move(camera));
    } catch (const InputError& error) {
      const std::string message = error.what();
      if (message.rfind(key + ": ", 0) == 0) throw;
      throw InputError(fmt::format("{}: {}", key, message));
    }
  }
  const size_t num_cameras =
      root.size() -
      std::count_if(root.begin(), root.end(), [](const auto& entry) {
        return entry.first.template as<std::string>().rfind(kDsecRectified,
                                                            0) == 0;
      });
  if (contents.cameras.size() != num_cameras)
    throw InputError(fmt::format(
        "the cameras must be numbered cam0 to cam{} without gaps, and no other "
        "keys are supported",
        num_cameras - 1));
  NameCameras(root, &contents.cameras);
  if (first_from_imu)
    contents.warnings.push_back(
        "camera-IMU extrinsics and time offsets are ignored");
  if (contents.cameras.size() > 1 && !contents.IsRig())
    contents.warnings.push_back(
        "no T_cn_cnm1 or T_cam_imu: importing cameras without relative poses");
  return contents;
}

bool IsKalibr(const std::string& text) {
  return text.find("cam0:") != std::string::npos &&
         text.find("camera_model:") != std::string::npos;
}

// ---- Writing ---------------------------------------------------------------

std::string PoseText(const Pose& pose) {
  const Eigen::Matrix3d r = pose.rotation.toRotationMatrix();
  const Eigen::Vector3d& t = pose.translation;
  std::string text = "  T_cn_cnm1:\n";
  for (int row = 0; row < 3; ++row)
    text += fmt::format("  - [{}]\n",
                        RealTexts({r(row, 0), r(row, 1), r(row, 2), t[row]}));
  return text + "  - [0.0, 0.0, 0.0, 1.0]\n";
}

std::string WriteKalibr(const WriteRequest& request) {
  std::string text;
  for (size_t c = 0; c < request.cameras.size(); ++c) {
    const OutputCamera& camera = request.cameras[c];
    const ConvertedCamera& lens = camera.lens;
    const std::string key = fmt::format("cam{}", c);
    const size_t num_coefficients =
        lens.external_model->Has("k1") ? 4 : 0;  // radtan and equidistant
    const size_t num_intrinsics = lens.values.size() - num_coefficients;
    std::vector<double> intrinsics = lens.values;
    intrinsics.resize(num_intrinsics);
    std::string overlaps;
    for (size_t other = 0; other < request.cameras.size(); ++other)
      if (other != c)
        overlaps += fmt::format("{}{}", overlaps.empty() ? "" : ", ", other);
    if (camera.fit)
      text += fmt::format("# Fitted {}: {}\n", lens.external_model->name,
                          FormatModelFit(*camera.fit));
    text += fmt::format(
        "{}:\n  camera_model: {}\n  intrinsics: [{}]\n  distortion_model: {}\n"
        "  distortion_coeffs: [{}]\n  resolution: [{}, {}]\n"
        "  rostopic: \"/{}/image_raw\"\n  cam_overlaps: [{}]\n",
        key, GetKalibrCameraModel(*lens.external_model), RealTexts(intrinsics),
        GetKalibrDistortionModel(*lens.external_model),
        RealTexts(lens.ValuesFrom(num_intrinsics)), lens.size.width,
        lens.size.height, IsRigCameraName(camera.name) ? camera.name : key,
        overlaps);
    if (c > 0 && camera.camera_from_rig)
      text += PoseText(*camera.camera_from_rig *
                       request.cameras[c - 1].camera_from_rig->Inverse());
  }
  return text;
}

}  // namespace

Format MakeKalibrFormat() {
  Format format;
  format.name = "kalibr";
  format.holds =
      "camchain .yaml: a camera or rig of pinhole, omni, ds and eucm cameras "
      "with radtan, equidistant or no distortion";
  format.external_models = GetKalibrModels();
  format.supports_rigs = true;
  format.recognizes = IsKalibr;
  format.read = ReadKalibr;
  format.write = WriteKalibr;
  return format;
}

}  // namespace raygrid
