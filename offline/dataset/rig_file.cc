#include "dataset/rig_file.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
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
  return ReadNamingFile(path, [&] { return ParseCameras(YAML::Load(text)); });
}

std::string FormatRigFile(const std::vector<RigFileCamera>& cameras) {
  std::string text = "cameras:\n";
  for (const RigFileCamera& camera : cameras) {
    text += fmt::format(
        "  \"{}\":\n"
        "    file: \"{}\"\n"
        "    camera_from_rig:\n",
        camera.name, camera.file);
    text += FormatPose(camera.camera_from_rig, "      ");
  }
  // The mandatory key is written last: truncated files are invalid.
  return text + "raygrid_rig: 1\n";
}

}  // namespace raygrid
