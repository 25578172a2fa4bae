#include "exchange/opencv_cameras.h"

#include <fmt/format.h>

#include <set>

#include "dataset/error.h"
#include "exchange/camera_keys.h"
#include "exchange/file_storage.h"
#include "exchange/opencv_boards.h"
#include "exchange/opencv_keys.h"
#include "exchange/opencv_models.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace opencv_file {
namespace {

// Reads R and T of cv::stereoCalibrate, which transform from the first camera's
// frame or the rig frame.
std::optional<Pose> ReadOpenCvPose(const CameraKeys& keys) {
  const std::string r_key = FindKey(keys, {"R", "Rot", "rotation_matrix"}),
                    t_key =
                        FindKey(keys, {"T", "t", "Trns", "translation_vector"});
  if (r_key.empty() || t_key.empty()) return std::nullopt;
  const StoredMatrix r = ParseStoredMatrix(keys[r_key], r_key),
                     t = ParseStoredMatrix(keys[t_key], t_key);
  if (r.rows != 3 || r.columns != 3 || t.data.size() != 3)
    throw InputError("R, T: expected 3 x 3 and 3 x 1");
  std::vector<double> rows;
  for (int row = 0; row < 3; ++row) {
    rows.insert(rows.end(), r.data.begin() + 3 * row,
                r.data.begin() + 3 * row + 3);
    rows.push_back(t.data[row]);
  }
  return PoseFromMatrix(rows, "R");
}

InputCamera ReadCamera(const CameraKeys& keys, const Affixes& affixes,
                       const ReadRequest& request,
                       std::vector<std::string>* warnings) {
  InputCamera camera;
  ConvertedCamera& lens = camera.lens;
  lens.size = ReadImageSize(keys, affixes);
  ReadIntrinsics(keys, affixes, &lens);
  DistortionCoefficients coefficients;
  // Files of depth sensors and renderers may lack distortion coefficients;
  // OpenCV's files always have them.
  if (lens.size == ImageSize{} || IsFileStorage(request.text) ||
      HasCoefficients(keys, affixes) || keys.HasKeyWith({"dist", "coef"}))
    coefficients = Coefficients(keys, affixes);
  else
    warnings->push_back(
        "no distortion coefficients: assuming a camera without distortion");
  lens.external_model = &DetermineModel(keys, affixes, request, lens.skew_px,
                                        &coefficients, warnings);
  lens.values.insert(lens.values.end(), coefficients.numbers.begin(),
                     coefficients.numbers.end());
  if (lens.external_model->name == kOmnidir) {
    const std::string xi = affixes.prefix + "xi" + affixes.suffix;
    const std::vector<double> numbers = AllNumbers(keys[xi], xi);
    if (numbers.size() != 1)
      throw InputError(fmt::format("{}: expected one number", xi));
    lens.values.push_back(numbers[0]);
    RequireModelOfFile(request, *lens.external_model);
  }
  return camera;
}

// Reads a single camera and the other data of its file.
InputCamera ReadSingle(const CameraKeys& keys, const YAML::Node& root,
                       const ReadRequest& request,
                       std::vector<std::string>* warnings) {
  InputCamera camera = ReadCamera(keys, {}, request, warnings);
  camera.name = GetKeyText(keys, kNameKeys);
  camera.serial = keys.Word("serial");
  camera.camera_from_rig = ReadOpenCvPose(keys);
  ReadBoardFeatures(root, request, &camera);
  camera.poses = ReadBoardPoses(root);
  keys.Skip(kOtherKeys);
  keys.NameOnly(kVagueKeys);
  keys.Finish(*camera.lens.external_model, warnings, camera.lens.values);
  return camera;
}

// Reads a file of several cameras, such as stereo_calib writes, and the
// relative pose of a pair if present.
void ReadMultipleCameras(const CameraKeys& keys,
                         const std::vector<Affixes>& cameras,
                         const ReadRequest& request,
                         ExchangeContents* contents) {
  for (const Affixes& affixes : cameras) {
    contents->cameras.push_back(
        ReadCamera(keys, affixes, request, &contents->warnings));
    contents->cameras.back().name = affixes.camera;
  }
  AssignPairPose(ReadOpenCvPose(keys), request.path, &contents->cameras);
  keys.Skip(kOtherKeys);
  keys.Finish(*contents->cameras.front().lens.external_model,
              &contents->warnings);
}

// Merges the separate mappings of intrinsics and distortion of a camera, as in
// Orbbec's SDK. Its distortion models 3 and 4 are OpenCV's; model 0 has no
// distortion.
YAML::Node JoinIntrinsics(const YAML::Node& node) {
  const YAML::Node intrinsic = node["intrinsic"],
                   distortion = node["distortion"];
  const auto has = [](const YAML::Node& map, const char* key) {
    return map.IsDefined() && map.IsMap() && map[key].IsDefined();
  };
  if (!has(intrinsic, "fx") || !has(distortion, "k1")) return node;
  constexpr int kNone = 0, kBrownConrady = 3, kBrownConradyK6 = 4;
  const YAML::Node model = distortion["model"];
  int number = -1;
  const bool is_numbered =
      model.IsDefined() && YAML::convert<int>::decode(model, number);
  if (is_numbered && number != kNone && number != kBrownConrady &&
      number != kBrownConradyK6)
    throw InputError(fmt::format(
        "distortion/model: {} is not supported; supported are 0, 3 and 4",
        number));
  YAML::Node joined(YAML::NodeType::Map);
  for (const auto& entry : node)
    if (entry.first.Scalar() != "intrinsic" &&
        entry.first.Scalar() != "distortion")
      joined[entry.first.Scalar()] = entry.second;
  for (const auto& entry : intrinsic)
    joined[entry.first.Scalar()] = entry.second;
  for (const auto& entry : distortion)
    if (!is_numbered)
      joined[entry.first.Scalar()] = entry.second;
    else if (entry.first.Scalar() != "model")
      joined[entry.first.Scalar()] =
          number == kNone ? YAML::Node(0) : YAML::Node(entry.second);
  return joined;
}

// Merges a camera's mapping of intrinsics into its own mapping, which may have
// the model, the image size, the name and the pose.
YAML::Node MergeIntrinsics(const YAML::Node& node) {
  if (!node.IsMap()) return node;
  for (const char* key : {"intrinsics", "intrinsic", "intrinsic_parameters",
                          "camera_intrinsics"}) {
    const YAML::Node intrinsics = node[key];
    if (!intrinsics.IsDefined() || !intrinsics.IsMap() ||
        !HasMatrix(CameraKeys(intrinsics)))
      continue;
    YAML::Node merged(YAML::NodeType::Map);
    for (const auto& entry : node)
      if (entry.first.Scalar() != key)
        merged[entry.first.Scalar()] = entry.second;
    for (const auto& entry : intrinsics)
      merged[entry.first.Scalar()] = entry.second;
    return merged;
  }
  return node;
}

// Appends numbers to the names of cameras that have the same name.
void MakeNamesUnique(std::vector<InputCamera>* cameras) {
  std::set<std::string> names;
  for (const InputCamera& camera : *cameras) names.insert(camera.name);
  if (names.size() == cameras->size()) return;
  for (size_t c = 0; c < cameras->size(); ++c)
    (*cameras)[c].name = fmt::format("cam{}", c);
}

}  // namespace

void ReadNamed(const YAML::Node& root, const ReadRequest& request, int depth,
               ExchangeContents* contents) {
  constexpr int kDeepest = 2;
  for (const auto& entry : root) {
    const YAML::Node node = root.IsMap() ? entry.second : YAML::Node(entry);
    if (!node.IsMap() && !node.IsSequence()) continue;
    if (node.IsMap()) {
      const YAML::Node joined = MergeIntrinsics(JoinIntrinsics(node));
      const CameraKeys keys(joined);
      if (HasMatrix(keys) && HasCoefficients(keys)) {
        InputCamera camera =
            ReadSingle(keys, joined, request, &contents->warnings);
        if (root.IsMap() && entry.first.IsScalar())
          camera.name = entry.first.as<std::string>();
        contents->cameras.push_back(std::move(camera));
        continue;
      }
    }
    if (depth < kDeepest) ReadNamed(node, request, depth + 1, contents);
  }
}

ExchangeContents ReadTree(const YAML::Node& tree, const ReadRequest& request) {
  const YAML::Node root = MergeIntrinsics(tree);
  const CameraKeys keys(root);
  const bool has_matrix = HasMatrix(keys);
  if (!has_matrix && keys.Has(kPointsKey))
    return ReadCornersOnly(root, request);
  ExchangeContents contents;
  if (has_matrix) {
    contents.cameras.push_back(
        ReadSingle(keys, root, request, &contents.warnings));
    return contents;
  }
  if (const auto cameras = FindCameraAffixes(keys); !cameras.empty()) {
    ReadMultipleCameras(keys, cameras, request, &contents);
    return contents;
  }
  if (const auto pose = ReadOpenCvPose(keys)) {
    contents.second_from_first = pose;
    return contents;
  }
  ReadNamed(root, request, 0, &contents);
  MakeNamesUnique(&contents.cameras);
  if (contents.cameras.empty())
    throw InputError("contains no camera: 'camera_matrix' is missing");
  return contents;
}

}  // namespace opencv_file
}  // namespace raygrid
