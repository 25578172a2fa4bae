#include "dataset/rig_file.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/pose_node.h"
#include "dataset/text_encoding.h"
#include "dataset/yaml_file.h"

namespace raygrid {
namespace {

// Throws exceptions of yaml-cpp, and InputError without the file name.
std::vector<RigFileCamera> ParseCameras(const YAML::Node& root) {
  RequireKind(root, "rig");
  if (root["raygrid_rig"].as<int>() != 1)
    throw InputError("unsupported version of rig.yaml");
  std::vector<RigFileCamera> cameras;
  std::set<std::string> names;
  for (const auto& entry : root["cameras"]) {
    const std::string name = entry.first.as<std::string>();
    if (!IsRigCameraName(name))
      throw InputError(fmt::format(
          "camera '{}': use only letters, digits, '-' and '_' in names",
          Printable(name)));
    if (!names.insert(name).second)
      throw InputError(fmt::format("duplicate camera name '{}'", name));
    cameras.push_back(
        {name, entry.second["file"].as<std::string>(),
         ParsePose("camera_from_rig", entry.second["camera_from_rig"])});
  }
  if (cameras.empty()) throw InputError("no cameras");
  return cameras;
}

PoseCovariance ParseCovariance(const YAML::Node& rows) {
  constexpr double kRounding = 1e-6;  // relative to the standard deviations
  PoseCovariance covariance;
  if (!rows.IsSequence() || rows.size() != 6)
    throw InputError("covariance: expected 6 rows of 6 numbers");
  for (int i = 0; i < 6; ++i) {
    if (!rows[i].IsSequence() || rows[i].size() != 6)
      throw InputError("covariance: expected 6 rows of 6 numbers");
    for (int k = 0; k < 6; ++k) covariance(i, k) = rows[i][k].as<double>();
  }
  if (!covariance.allFinite() || !(covariance.diagonal().minCoeff() >= 0))
    throw InputError("covariance: variances must be finite and not negative");
  const Eigen::Matrix<double, 6, 1> scale =
      covariance.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const PoseCovariance correlation =
      scale.asDiagonal() * covariance * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<PoseCovariance> solver(
      correlation, Eigen::EigenvaluesOnly);
  if (!((correlation - correlation.transpose()).cwiseAbs().maxCoeff() <
        kRounding) ||
      !(solver.eigenvalues()[0] > -kRounding))
    throw InputError("covariance: must be symmetric and positive semidefinite");
  return covariance;
}

// As ParseCameras().
std::vector<RelativePoseCovariance> ParsePairCovariances(
    const YAML::Node& root) {
  std::set<std::string> names;
  for (const RigFileCamera& camera : ParseCameras(root))
    names.insert(camera.name);
  std::vector<RelativePoseCovariance> pairs;
  const YAML::Node list = root["relative_poses"];
  if (!list) return pairs;
  for (const auto& entry : list) {
    const auto cameras = entry["cameras"].as<std::vector<std::string>>();
    if (cameras.size() != 2 || cameras[0] == cameras[1])
      throw InputError("relative_poses: expected two different cameras");
    for (const std::string& name : cameras)
      if (names.count(name) == 0)
        throw InputError(fmt::format(
            "relative_poses: no camera '{}' in this rig", Printable(name)));
    if (FindRelativePose(pairs, cameras[0], cameras[1]))
      throw InputError(fmt::format("relative_poses: duplicate pair {}, {}",
                                   cameras[0], cameras[1]));
    pairs.push_back(
        {cameras[0], cameras[1], ParseCovariance(entry["covariance"])});
  }
  return pairs;
}

std::string FormatPair(const RelativePoseCovariance& pair) {
  std::string text =
      fmt::format("  - cameras: [\"{}\", \"{}\"]\n    covariance:\n",
                  pair.first, pair.second);
  for (int i = 0; i < 6; ++i) {
    text += "      - [";
    for (int k = 0; k < 6; ++k)
      text += fmt::format("{}{:.9g}", k > 0 ? ", " : "",
                          pair.covariance(i, k) + 0.0);
    text += "]\n";
  }
  return text;
}

}  // namespace

bool IsRigCameraName(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-';
  });
}

std::vector<RigFileCamera> ReadRigFile(const std::string& path) {
  return ParseRigFile(path, ReadFile(path));
}

std::vector<RigFileCamera> ParseRigFile(const std::string& path,
                                        const std::string& text) {
  RequireYamlFile(path, text);
  return ReadNamingFile(path, [&] {
    const YAML::Node root = YAML::Load(text);
    ParsePairCovariances(root);
    return ParseCameras(root);
  });
}

double RelativePoseCovariance::RotationStdDev() const {
  return std::sqrt(covariance.topLeftCorner<3, 3>().trace());
}

double RelativePoseCovariance::DistanceStdDev(
    const Eigen::Vector3d& translation) const {
  const Eigen::Matrix3d block = covariance.bottomRightCorner<3, 3>();
  const Eigen::Vector3d along = translation.normalized();
  const double variance =
      translation.isZero(0)
          ? Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(block)
                .eigenvalues()[2]
          : along.dot(block * along);
  return std::sqrt(std::max(0.0, variance));
}

std::vector<RelativePoseCovariance> ParseRelativePoseCovariances(
    const std::string& path, const std::string& text) {
  RequireYamlFile(path, text);
  return ReadNamingFile(path,
                        [&] { return ParsePairCovariances(YAML::Load(text)); });
}

const RelativePoseCovariance* FindRelativePose(
    const std::vector<RelativePoseCovariance>& poses, const std::string& a,
    const std::string& b) {
  for (const RelativePoseCovariance& pose : poses)
    if ((pose.first == a && pose.second == b) ||
        (pose.first == b && pose.second == a))
      return &pose;
  return nullptr;
}

std::string FormatRigFile(
    const std::vector<RigFileCamera>& cameras,
    const std::vector<RelativePoseCovariance>& relative_poses) {
  std::string text = "cameras:\n";
  for (const RigFileCamera& camera : cameras) {
    text += fmt::format(
        "  \"{}\":\n"
        "    file: \"{}\"\n"
        "    camera_from_rig:\n",
        camera.name, camera.file);
    text += FormatPose(camera.camera_from_rig, "      ");
  }
  if (!relative_poses.empty())
    text +=
        "# Of second_from_first: exp(r) R, t + d; rows r (rad), then d (m).\n"
        "relative_poses:\n";
  for (const RelativePoseCovariance& pair : relative_poses)
    text += FormatPair(pair);
  // The mandatory key is written last: truncated files are invalid.
  return text + "raygrid_rig: 1\n";
}

}  // namespace raygrid
