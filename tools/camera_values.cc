#include "camera_values.h"

#include <fmt/format.h>

#include <filesystem>
#include <set>
#include <system_error>

#include "dataset/error.h"
#include "dataset/rig_file.h"

namespace raygrid {

NamedValue ParseNamedValue(const std::string& text) {
  const size_t equals = text.find('=');
  if (equals == std::string::npos) return {"", text};
  return {text.substr(0, equals), text.substr(equals + 1)};
}

void RequireCameraName(const std::string& name) {
  if (!IsRigCameraName(name))
    throw Error(
        ExitCode::kUsage,
        fmt::format("camera name '{}': use only letters, digits, '-' and '_'",
                    name));
}

std::vector<NamedValue> ParseCameraValues(
    const std::string& option, const std::string& value_name,
    const std::vector<std::string>& texts) {
  std::vector<NamedValue> cameras;
  std::set<std::string> names;
  for (const std::string& text : texts) {
    const NamedValue& camera = cameras.emplace_back(ParseNamedValue(text));
    if (camera.name.empty())
      throw Error(ExitCode::kUsage, fmt::format("{} {}: expected NAME={}",
                                                option, text, value_name));
    RequireCameraName(camera.name);
    if (!names.insert(camera.name).second)
      throw Error(ExitCode::kUsage, fmt::format("{} {}: duplicate camera name",
                                                option, camera.name));
  }
  return cameras;
}

void RequireSeparateFolderNames(const std::string& option,
                                const std::vector<NamedValue>& folders) {
  for (size_t k = 1; k < folders.size(); ++k)
    for (size_t before = 0; before < k; ++before) {
      std::error_code ignored;
      if (std::filesystem::equivalent(folders[before].value, folders[k].value,
                                      ignored))
        throw Error(ExitCode::kUsage,
                    fmt::format("{} {}={}: same folder as camera {}; use "
                                "different images for each camera",
                                option, folders[k].name, folders[k].value,
                                folders[before].name));
    }
}

}  // namespace raygrid
