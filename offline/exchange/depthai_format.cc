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

constexpr char kDevCameras[] = "cameraData";
constexpr char kDevCoefficients[] = "distortionCoeff";
constexpr char kDevMatrix[] = "intrinsicMatrix";
constexpr char kDevExtrinsics[] = "extrinsics";
constexpr char kDevRotation[] = "rotationMatrix";
constexpr char kDevTranslation[] = "translation";
constexpr char kDevTarget[] = "toCameraSocket";
constexpr char kDevUnit[] = "lengthUnit";
constexpr char kDevFisheye[] = "fisheye";
constexpr int kDevNumCoefficients = 14, kDevNumSockets = 10;
// Values of depthai's enum CameraModel.
constexpr int kDevPerspectiveType = 0, kDevFisheyeType = 1;
// Metres per unit of depthai's enum LengthUnit: metre, centimetre, millimetre.
constexpr std::array<double, 3> kDevUnitM = {1, 0.01, 0.001};
constexpr int kDevCentimetres = 1;

const std::vector<ExternalModel>& GetDepthAiModels() {
  static const std::vector<ExternalModel> external_models = {
      MakeOpenCvModel("perspective", 0), MakeOpenCvModel("perspective5", 5),
      MakeOpenCvModel("perspective8", 8), MakeOpenCvModel("perspective14", 14),
      MakeOpenCvFisheyeModel(kDevFisheye)};
  return external_models;
}

const ExternalModel& GetDepthAiModel(bool is_fisheye, size_t num_coefficients) {
  for (const ExternalModel& external_model : GetDepthAiModels())
    if ((external_model.name == kDevFisheye) == is_fisheye &&
        external_model.parameters.size() >= 4 + num_coefficients)
      return external_model;
  throw InputError(
      fmt::format("{}: too many non-zero coefficients", kDevCoefficients));
}

// ---- Reading ---------------------------------------------------------------

// A camera of the file and the socket of the camera that its extrinsics refer
// to.
struct DevCamera {
  int socket = 0;
  ReadLens lens;
  int target = -1;
  Pose target_from_camera;
};

std::vector<double> RowsOfMatrix(const YAML::Node& node,
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

int WholeNumber(const YAML::Node& node, const std::string& name) {
  const double number = FiniteNumber(node, name);
  if (number != std::floor(number) || std::abs(number) > 1e6)
    throw InputError(fmt::format("{}: expected an integer", name));
  return static_cast<int>(number);
}

ConvertedCamera ReadDevLens(const CameraKeys& camera) {
  const int type = camera.Has("cameraType")
                       ? WholeNumber(camera["cameraType"], "cameraType")
                       : kDevPerspectiveType;
  if (type != kDevPerspectiveType && type != kDevFisheyeType)
    throw InputError(fmt::format(
        "cameraType {}: unsupported, expected 0 (perspective) or 1 (fisheye)",
        type));
  ConvertedCamera lens;
  ReadCameraMatrix(RowsOfMatrix(camera[kDevMatrix], kDevMatrix), kDevMatrix,
                   &lens);
  std::vector<double> coefficients =
      FiniteNumbers(camera[kDevCoefficients], kDevCoefficients);
  while (!coefficients.empty() && coefficients.back() == 0)
    coefficients.pop_back();
  lens.external_model =
      &GetDepthAiModel(type == kDevFisheyeType, coefficients.size());
  lens.size = {SidePx(camera["width"], "width"),
               SidePx(camera["height"], "height")};
  lens.values.insert(lens.values.end(), coefficients.begin(),
                     coefficients.end());
  lens.values.resize(lens.external_model->parameters.size(), 0);
  return lens;
}

void ReadDevLink(const YAML::Node& node, DevCamera* camera) {
  if (!node || !node.IsMap() || !node[kDevTarget]) return;
  camera->target = WholeNumber(node[kDevTarget], kDevTarget);
  if (camera->target < 0) return;
  const int unit =
      node[kDevUnit] ? WholeNumber(node[kDevUnit], kDevUnit) : kDevCentimetres;
  if (unit < 0 || unit >= static_cast<int>(kDevUnitM.size()))
    throw InputError(
        fmt::format("{} {}: unsupported, expected 0 (m), 1 (cm) or 2 (mm)",
                    kDevUnit, unit));
  const std::vector<double> r = RowsOfMatrix(node[kDevRotation], kDevRotation);
  const YAML::Node t = node[kDevTranslation];
  if (!t || !t.IsMap())
    throw InputError(fmt::format("'{}' is missing", kDevTranslation));
  std::vector<double> rows;
  for (int row = 0; row < 3; ++row) {
    rows.insert(rows.end(), r.begin() + 3 * row, r.begin() + 3 * row + 3);
    const std::string axis(1, "xyz"[row]);
    rows.push_back(FiniteNumber(t[axis], kDevTranslation) * kDevUnitM[unit]);
  }
  camera->target_from_camera = PoseFromMatrix(rows, kDevExtrinsics);
}

DevCamera ReadDevCamera(const YAML::Node& entry,
                        std::vector<std::string>* warnings) {
  if (!entry.IsSequence() || entry.size() != 2 || !entry[1].IsMap())
    throw InputError("expected pairs of socket and camera");
  DevCamera camera;
  camera.socket = WholeNumber(entry[0], "socket");
  if (camera.socket < 0 || camera.socket >= kDevNumSockets)
    throw InputError(fmt::format("socket {}: out of range, 0 to {}",
                                 camera.socket, kDevNumSockets - 1));
  const CameraKeys keys(entry[1], fmt::format("socket {}", camera.socket));
  camera.lens.lens = ReadDevLens(keys);
  ReadDevLink(keys[kDevExtrinsics], &camera);
  keys.Skip({"lensPosition", "specHfovDeg"});
  keys.Finish(*camera.lens.lens.external_model, warnings);
  return camera;
}

// Chains the extrinsics. Returns the poses, relative to the first camera, of
// all cameras that are connected to it.
std::map<int, Pose> PosesOfLinks(const std::vector<DevCamera>& cameras) {
  std::map<int, Pose> camera_from_rig = {{cameras.front().socket, Pose{}}};
  for (size_t round = 0; round < cameras.size(); ++round)
    for (const DevCamera& camera : cameras) {
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

void TakeDevPoses(const std::vector<DevCamera>& cameras,
                  ExchangeContents* contents) {
  if (cameras.size() < 2) return;
  const std::map<int, Pose> poses = PosesOfLinks(cameras);
  for (const DevCamera& camera : cameras)
    if (poses.count(camera.socket) == 0) {
      contents->warnings.push_back(
          fmt::format("importing cameras without a rig: no {} connects the "
                      "first camera to socket {}",
                      kDevExtrinsics, camera.socket));
      return;
    }
  for (size_t c = 0; c < cameras.size(); ++c)
    contents->cameras[c].camera_from_rig = poses.at(cameras[c].socket);
}

// Assigns the names written by raygrid, or the names of the sockets.
void NameDevCameras(const YAML::Node& root,
                    const std::vector<DevCamera>& cameras,
                    ExchangeContents* contents) {
  const YAML::Node own = root[kRaygridKey];
  const bool is_own = own && own.IsSequence() && own.size() == cameras.size();
  for (size_t c = 0; c < cameras.size(); ++c) {
    ReadLens& camera = contents->cameras[c];
    if (is_own) ParseRaygridJson(own[c], &camera);
    if (camera.name.empty() && cameras.size() > 1)
      camera.name = fmt::format("CAM_{}", "ABCDEFGHIJ"[cameras[c].socket]);
  }
}

ExchangeContents ReadDepthAi(const ReadRequest& request) {
  const YAML::Node root = LoadForeignMap(request.path, request.text);
  if (!root[kDevCameras] || !root[kDevCameras].IsSequence() ||
      root[kDevCameras].size() == 0)
    throw InputError(
        fmt::format("not a calibration: '{}' has no camera", kDevCameras));
  ExchangeContents contents;
  std::vector<DevCamera> cameras;
  for (const YAML::Node& entry : root[kDevCameras]) {
    try {
      cameras.push_back(ReadDevCamera(entry, &contents.warnings));
    } catch (const InputError& error) {
      throw InputError(
          fmt::format("{}[{}]: {}", kDevCameras, cameras.size(), error.what()));
    }
    for (size_t c = 0; c + 1 < cameras.size(); ++c)
      if (cameras[c].socket == cameras.back().socket)
        throw InputError(fmt::format("{}: duplicate socket {}", kDevCameras,
                                     cameras[c].socket));
    contents.cameras.push_back(cameras.back().lens);
  }
  TakeDevPoses(cameras, &contents);
  NameDevCameras(root, cameras, &contents);
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
int SocketOfName(const std::string& name) {
  const std::string word = Lowercase(name);
  if (word.size() == 5 && word.compare(0, 4, "cam_") == 0 && word[4] >= 'a' &&
      word[4] < 'a' + kDevNumSockets)
    return word[4] - 'a';
  if (word == "rgb" || word == "color" || word == "center") return 0;
  if (word == "left") return 1;
  if (word == "right") return 2;
  return -1;
}

// Assigns sockets by camera names. If these do not identify distinct sockets, a
// pair gets the sockets of Luxonis's stereo pairs, and other rigs get the
// sockets from the first on.
std::vector<int> AssignSockets(const std::vector<WrittenLens>& cameras) {
  if (cameras.size() > static_cast<size_t>(kDevNumSockets))
    throw Error(ExitCode::kUsage,
                fmt::format("--to depthai: the rig has {1} cameras, but a "
                            "device has {0} sockets",
                            kDevNumSockets, cameras.size()));
  std::vector<int> sockets;
  for (const WrittenLens& camera : cameras) {
    const int socket = SocketOfName(camera.name);
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

Json DevMatrix(const Eigen::Matrix3d& matrix) {
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row)
    rows.push_back(
        {matrix(row, 0) + 0.0, matrix(row, 1) + 0.0, matrix(row, 2) + 0.0});
  return rows;
}

// depthai reads the nominal ("spec") translation by default, so it is set to
// the calibrated one.
Json DevLink(const Pose& target_from_camera, int target) {
  const Eigen::Vector3d cm =
      target_from_camera.translation.array() / kDevUnitM[kDevCentimetres] + 0.0;
  const Json translation = {{"x", cm.x()}, {"y", cm.y()}, {"z", cm.z()}};
  return {
      {kDevRotation,
       target < 0 ? Json::array()
                  : DevMatrix(target_from_camera.rotation.toRotationMatrix())},
      {"specTranslation", translation},
      {kDevTarget, target},
      {kDevTranslation, translation}};
}

Json DevLens(const ConvertedCamera& lens) {
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = lens.Value("fx");
  k(1, 1) = lens.Value("fy");
  k(0, 2) = lens.Value("cx");
  k(1, 2) = lens.Value("cy");
  std::vector<double> coefficients = lens.ValuesFrom(4);
  coefficients.resize(kDevNumCoefficients, 0);
  return {{"cameraType", lens.external_model->name == kDevFisheye
                             ? kDevFisheyeType
                             : kDevPerspectiveType},
          {kDevCoefficients, coefficients},
          {"height", lens.size.height},
          {kDevMatrix, DevMatrix(k)},
          {"lensPosition", 0},
          {"specHfovDeg", 0.0},
          {"width", lens.size.width}};
}

// Returns the rectifying rotations of a stereo pair, which devices use
// unchanged.
Json DevRectification(const WriteRequest& request,
                      const std::vector<int>& sockets) {
  const std::vector<WrittenLens>& cameras = request.cameras;
  if (cameras.size() != 2 || !cameras[0].rectified || !cameras[1].rectified)
    return Json();
  // The projection matrix P of the right camera contains the baseline.
  const int right = cameras[0].rectified->IsBeside() ? 0 : 1, left = 1 - right;
  return {{"leftCameraSocket", sockets[left]},
          {"rectifiedRotationLeft", DevMatrix(cameras[left].rectified->r)},
          {"rectifiedRotationRight", DevMatrix(cameras[right].rectified->r)},
          {"rightCameraSocket", sockets[right]}};
}

std::string WriteDepthAi(const WriteRequest& request) {
  const std::vector<int> sockets = AssignSockets(request.cameras);
  Json cameras = Json::array(), own = Json::array();
  const Pose first_from_rig =
      request.cameras.front().camera_from_rig.value_or(Pose{});
  for (size_t c = 0; c < request.cameras.size(); ++c) {
    const WrittenLens& camera = request.cameras[c];
    Json entry = DevLens(camera.lens);
    entry[kDevExtrinsics] =
        c > 0 && camera.camera_from_rig
            ? DevLink(first_from_rig * camera.camera_from_rig->Inverse(),
                      sockets[0])
            : DevLink(Pose{}, -1);
    cameras.push_back({sockets[c], std::move(entry)});
    own.push_back(MakeRaygridJson(camera));
  }
  Json root = {{kDevCameras, std::move(cameras)}};
  Json rectification = DevRectification(request, sockets);
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
