#include "exchange/depthai_format.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/camera_keys.h"
#include "exchange/opencv_model_list.h"
#include "exchange/raygrid_json.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kDepthaiCameras[] = "cameraData";
constexpr char kDepthaiCoefficients[] = "distortionCoeff";
constexpr char kDepthaiMatrix[] = "intrinsicMatrix";
constexpr char kDepthaiExtrinsics[] = "extrinsics";
constexpr char kDepthaiRotation[] = "rotationMatrix";
constexpr char kDepthaiTranslation[] = "translation";
constexpr char kDepthaiTarget[] = "toCameraSocket";
constexpr char kDepthaiUnit[] = "lengthUnit";
constexpr char kDepthaiFisheye[] = "fisheye";
constexpr int kDepthaiNumCoefficients = 14, kDepthaiNumSockets = 10;
// Values of depthai's enum CameraModel.
constexpr int kDepthaiPerspectiveType = 0, kDepthaiFisheyeType = 1;
// Metres per unit of depthai's enum LengthUnit: metre, centimetre, millimetre.
constexpr std::array<double, 3> kDepthaiUnitM = {1, 0.01, 0.001};
constexpr int kDepthaiCentimetres = 1;

const std::vector<ExternalModel>& GetDepthAiModels() {
  static const std::vector<ExternalModel> external_models = {
      MakeOpenCvModel("perspective", 0), MakeOpenCvModel("perspective5", 5),
      MakeOpenCvModel("perspective8", 8), MakeOpenCvModel("perspective14", 14),
      MakeOpenCvFisheyeModel(kDepthaiFisheye)};
  return external_models;
}

const ExternalModel& GetDepthAiModel(bool is_fisheye, size_t num_coefficients) {
  for (const ExternalModel& external_model : GetDepthAiModels())
    if ((external_model.name == kDepthaiFisheye) == is_fisheye &&
        external_model.parameters.size() >= 4 + num_coefficients)
      return external_model;
  throw InputError(
      fmt::format("{}: too many non-zero coefficients", kDepthaiCoefficients));
}

// ---- Reading ---------------------------------------------------------------

// A camera of the file and the socket of the camera that its extrinsics refer
// to.
struct DepthaiCamera {
  int socket = 0;
  InputCamera lens;
  int target = -1;
  Pose target_from_camera;
};

std::vector<double> ReadMatrixRows(const YAML::Node& node,
                                   const std::string& name) {
  if (!node || !node.IsSequence() || node.size() != 3)
    throw InputError(fmt::format("{}: expected 3 rows of 3 numbers", name));
  std::vector<double> all;
  for (const YAML::Node& row : node) {
    const std::vector<double> numbers = FiniteNumbers(row, name, 3);
    all.insert(all.end(), numbers.begin(), numbers.end());
  }
  return all;
}

int ReadInteger(const YAML::Node& node, const std::string& name) {
  const double number = FiniteNumber(node, name);
  if (number != std::floor(number) || std::abs(number) > 1e6)
    throw InputError(fmt::format("{}: expected an integer", name));
  return static_cast<int>(number);
}

ConvertedCamera ReadDepthaiIntrinsics(const CameraKeys& camera) {
  const int type = camera.Has("cameraType")
                       ? ReadInteger(camera["cameraType"], "cameraType")
                       : kDepthaiPerspectiveType;
  if (type != kDepthaiPerspectiveType && type != kDepthaiFisheyeType)
    throw InputError(fmt::format(
        "cameraType {}: unsupported, expected 0 (perspective) or 1 (fisheye)",
        type));
  ConvertedCamera lens;
  ReadCameraMatrix(ReadMatrixRows(camera[kDepthaiMatrix], kDepthaiMatrix),
                   kDepthaiMatrix, &lens);
  std::vector<double> coefficients =
      FiniteNumbers(camera[kDepthaiCoefficients], kDepthaiCoefficients);
  while (!coefficients.empty() && coefficients.back() == 0)
    coefficients.pop_back();
  lens.external_model =
      &GetDepthAiModel(type == kDepthaiFisheyeType, coefficients.size());
  lens.size = {SidePx(camera["width"], "width"),
               SidePx(camera["height"], "height")};
  lens.values.insert(lens.values.end(), coefficients.begin(),
                     coefficients.end());
  lens.values.resize(lens.external_model->parameters.size(), 0);
  return lens;
}

void ReadDepthaiLink(const YAML::Node& node, DepthaiCamera* camera) {
  if (!node || !node.IsMap() || !node[kDepthaiTarget]) return;
  camera->target = ReadInteger(node[kDepthaiTarget], kDepthaiTarget);
  if (camera->target < 0) return;
  const int unit = node[kDepthaiUnit]
                       ? ReadInteger(node[kDepthaiUnit], kDepthaiUnit)
                       : kDepthaiCentimetres;
  if (unit < 0 || unit >= static_cast<int>(kDepthaiUnitM.size()))
    throw InputError(
        fmt::format("{} {}: unsupported, expected 0 (m), 1 (cm) or 2 (mm)",
                    kDepthaiUnit, unit));
  const std::vector<double> r =
      ReadMatrixRows(node[kDepthaiRotation], kDepthaiRotation);
  const YAML::Node t = node[kDepthaiTranslation];
  if (!t || !t.IsMap())
    throw InputError(fmt::format("'{}' is missing", kDepthaiTranslation));
  std::vector<double> rows;
  for (int row = 0; row < 3; ++row) {
    rows.insert(rows.end(), r.begin() + 3 * row, r.begin() + 3 * row + 3);
    const std::string axis(1, "xyz"[row]);
    rows.push_back(FiniteNumber(t[axis], kDepthaiTranslation) *
                   kDepthaiUnitM[unit]);
  }
  camera->target_from_camera = PoseFromMatrix(rows, kDepthaiExtrinsics);
}

DepthaiCamera ReadDepthaiCamera(const YAML::Node& entry,
                                std::vector<std::string>* warnings) {
  if (!entry.IsSequence() || entry.size() != 2 || !entry[1].IsMap())
    throw InputError("expected pairs of socket and camera");
  DepthaiCamera camera;
  camera.socket = ReadInteger(entry[0], "socket");
  if (camera.socket < 0 || camera.socket >= kDepthaiNumSockets)
    throw InputError(fmt::format("socket {}: out of range, 0 to {}",
                                 camera.socket, kDepthaiNumSockets - 1));
  const CameraKeys keys(entry[1], fmt::format("socket {}", camera.socket));
  camera.lens.lens = ReadDepthaiIntrinsics(keys);
  ReadDepthaiLink(keys[kDepthaiExtrinsics], &camera);
  keys.Skip({"lensPosition", "specHfovDeg"});
  keys.Finish(*camera.lens.lens.external_model, warnings);
  return camera;
}

// Chains the extrinsics. Returns the poses, relative to the first camera, of
// all cameras that are connected to it.
std::map<int, Pose> ComputePosesFromLinks(
    const std::vector<DepthaiCamera>& cameras) {
  std::map<int, Pose> camera_from_rig = {{cameras.front().socket, Pose{}}};
  for (size_t round = 0; round < cameras.size(); ++round)
    for (const DepthaiCamera& camera : cameras) {
      if (camera.target < 0) continue;
      const auto own = camera_from_rig.find(camera.socket),
                 target = camera_from_rig.find(camera.target);
      const auto none = camera_from_rig.end();
      if (own == none && target != none)
        camera_from_rig[camera.socket] =
            camera.target_from_camera.Inverse() * target->second;
      else if (own != none && target == none)
        camera_from_rig[camera.target] =
            camera.target_from_camera * own->second;
    }
  return camera_from_rig;
}

void ReadDepthaiPoses(const std::vector<DepthaiCamera>& cameras,
                      ExchangeContents* contents) {
  if (cameras.size() < 2) return;
  const std::map<int, Pose> poses = ComputePosesFromLinks(cameras);
  for (const DepthaiCamera& camera : cameras)
    if (poses.count(camera.socket) == 0) {
      contents->warnings.push_back(
          fmt::format("no {} connects the first camera to socket {}: importing "
                      "cameras without relative poses",
                      kDepthaiExtrinsics, camera.socket));
      return;
    }
  for (size_t c = 0; c < cameras.size(); ++c)
    contents->cameras[c].camera_from_rig = poses.at(cameras[c].socket);
}

// Assigns the names written by raygrid, or the names of the sockets.
void NameDepthaiCameras(const YAML::Node& root,
                        const std::vector<DepthaiCamera>& cameras,
                        ExchangeContents* contents) {
  const YAML::Node own = root[kRaygridKey];
  const bool has_own_names =
      own && own.IsSequence() && own.size() == cameras.size();
  for (size_t c = 0; c < cameras.size(); ++c) {
    InputCamera& camera = contents->cameras[c];
    if (has_own_names) ParseRaygridJson(own[c], &camera);
    if (camera.name.empty() && cameras.size() > 1)
      camera.name = fmt::format("CAM_{}", "ABCDEFGHIJ"[cameras[c].socket]);
  }
}

ExchangeContents ReadDepthAi(const ReadRequest& request) {
  const YAML::Node root = LoadForeignMap(request.path, request.text);
  if (!root[kDepthaiCameras] || !root[kDepthaiCameras].IsSequence() ||
      root[kDepthaiCameras].size() == 0)
    throw InputError(
        fmt::format("not a calibration: '{}' has no camera", kDepthaiCameras));
  ExchangeContents contents;
  std::vector<DepthaiCamera> cameras;
  for (const YAML::Node& entry : root[kDepthaiCameras]) {
    try {
      cameras.push_back(ReadDepthaiCamera(entry, &contents.warnings));
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}[{}]: {}", kDepthaiCameras,
                                   cameras.size(), error.what()));
    }
    for (size_t c = 0; c + 1 < cameras.size(); ++c)
      if (cameras[c].socket == cameras.back().socket)
        throw InputError(fmt::format("{}: duplicate socket {}", kDepthaiCameras,
                                     cameras[c].socket));
    contents.cameras.push_back(cameras.back().lens);
  }
  ReadDepthaiPoses(cameras, &contents);
  NameDepthaiCameras(root, cameras, &contents);
  return contents;
}

bool IsDepthAi(const std::string& text) {
  for (const char* word : {"\"cameraData\"", "\"distortionCoeff\""})
    if (text.find(word) == std::string::npos) return false;
  return true;
}

// ---- Writing ---------------------------------------------------------------

// Returns the socket for a name: CAM_A etc., or Luxonis's names of the first
// three sockets.
int GetSocket(const std::string& name) {
  const std::string word = Lowercase(name);
  if (word.size() == 5 && word.compare(0, 4, "cam_") == 0 && word[4] >= 'a' &&
      word[4] < 'a' + kDepthaiNumSockets)
    return word[4] - 'a';
  if (word == "rgb" || word == "color" || word == "center") return 0;
  if (word == "left") return 1;
  if (word == "right") return 2;
  return -1;
}

// Assigns sockets by camera names. If these do not identify distinct sockets, a
// pair gets the sockets of Luxonis's stereo pairs, and other rigs get the
// sockets from the first on.
std::vector<int> AssignSockets(const std::vector<OutputCamera>& cameras) {
  if (cameras.size() > static_cast<size_t>(kDepthaiNumSockets))
    throw Error(ExitCode::kUsage,
                fmt::format("--to depthai: the rig has {1} cameras, but a "
                            "device has {0} sockets",
                            kDepthaiNumSockets, cameras.size()));
  std::vector<int> sockets;
  for (const OutputCamera& camera : cameras) {
    const int socket = GetSocket(camera.name);
    if (socket < 0 || std::count(sockets.begin(), sockets.end(), socket) > 0)
      break;
    sockets.push_back(socket);
  }
  if (sockets.size() == cameras.size()) return sockets;
  sockets.clear();
  for (size_t c = 0; c < cameras.size(); ++c)
    sockets.push_back(static_cast<int>(c) + (cameras.size() == 2 ? 1 : 0));
  return sockets;
}

Json MakeDepthaiMatrix(const Eigen::Matrix3d& matrix) {
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row)
    rows.push_back(
        {matrix(row, 0) + 0.0, matrix(row, 1) + 0.0, matrix(row, 2) + 0.0});
  return rows;
}

// depthai reads the nominal ("spec") translation by default, so it is set to
// the calibrated one.
Json MakeDepthaiLink(const Pose& target_from_camera, int target) {
  const Eigen::Vector3d cm = target_from_camera.translation.array() /
                                 kDepthaiUnitM[kDepthaiCentimetres] +
                             0.0;
  const Json translation = {{"x", cm.x()}, {"y", cm.y()}, {"z", cm.z()}};
  return {{kDepthaiRotation,
           target < 0 ? Json::array()
                      : MakeDepthaiMatrix(
                            target_from_camera.rotation.toRotationMatrix())},
          {"specTranslation", translation},
          {kDepthaiTarget, target},
          {kDepthaiTranslation, translation}};
}

Json MakeDepthaiCamera(const ConvertedCamera& lens) {
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = lens.Value("fx");
  k(1, 1) = lens.Value("fy");
  k(0, 2) = lens.Value("cx");
  k(1, 2) = lens.Value("cy");
  std::vector<double> coefficients = lens.ValuesFrom(4);
  coefficients.resize(kDepthaiNumCoefficients, 0);
  return {{"cameraType", lens.external_model->name == kDepthaiFisheye
                             ? kDepthaiFisheyeType
                             : kDepthaiPerspectiveType},
          {kDepthaiCoefficients, coefficients},
          {"height", lens.size.height},
          {kDepthaiMatrix, MakeDepthaiMatrix(k)},
          {"lensPosition", 0},
          {"specHfovDeg", 0.0},
          {"width", lens.size.width}};
}

// Returns the rectifying rotations of a stereo pair, which devices use
// unchanged.
Json MakeDepthaiRectification(const WriteRequest& request,
                              const std::vector<int>& sockets) {
  const std::vector<OutputCamera>& cameras = request.cameras;
  if (cameras.size() != 2 || !cameras[0].rectified || !cameras[1].rectified)
    return Json();
  // The projection matrix P of the right camera contains the baseline.
  const int right = cameras[0].rectified->HasBaseline() ? 0 : 1,
            left = 1 - right;
  return {
      {"leftCameraSocket", sockets[left]},
      {"rectifiedRotationLeft", MakeDepthaiMatrix(cameras[left].rectified->r)},
      {"rectifiedRotationRight",
       MakeDepthaiMatrix(cameras[right].rectified->r)},
      {"rightCameraSocket", sockets[right]}};
}

std::string WriteDepthAi(const WriteRequest& request) {
  const std::vector<int> sockets = AssignSockets(request.cameras);
  Json cameras = Json::array(), own = Json::array();
  const Pose first_from_rig =
      request.cameras.front().camera_from_rig.value_or(Pose{});
  for (size_t c = 0; c < request.cameras.size(); ++c) {
    const OutputCamera& camera = request.cameras[c];
    Json entry = MakeDepthaiCamera(camera.lens);
    entry[kDepthaiExtrinsics] =
        c > 0 && camera.camera_from_rig
            ? MakeDepthaiLink(
                  first_from_rig * camera.camera_from_rig->Inverse(),
                  sockets[0])
            : MakeDepthaiLink(Pose{}, -1);
    cameras.push_back({sockets[c], std::move(entry)});
    own.push_back(MakeRaygridJson(camera));
  }
  Json root = {{kDepthaiCameras, std::move(cameras)}};
  Json rectification = MakeDepthaiRectification(request, sockets);
  if (!rectification.is_null())
    root["stereoRectificationData"] = std::move(rectification);
  root["version"] = 7;
  root[kRaygridKey] = std::move(own);
  return root.dump(4) + "\n";
}

}  // namespace

Format MakeDepthAiFormat() {
  Format format;
  format.name = "depthai";
  format.holds =
      "Luxonis: calibration.json of a camera or rig; the socket follows from "
      "the name, such as left or CAM_B";
  format.external_models = GetDepthAiModels();
  format.ending = ".json";
  format.supports_rigs = true;
  format.supports_pairs = true;
  format.recognizes = IsDepthAi;
  format.read = ReadDepthAi;
  format.write = WriteDepthAi;
  return format;
}

}  // namespace raygrid
