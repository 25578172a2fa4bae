#include "named_camera.h"

#include <fmt/format.h>

#include <set>

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
    throw Error(ExitCode::kUsage,
                fmt::format("camera name '{}': give it one of letters, digits, "
                            "'-' and '_'",
                            name));
}

std::vector<NamedValue> ParseNamedCameras(
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
      throw Error(
          ExitCode::kUsage,
          fmt::format("{} {}: two cameras of one name", option, camera.name));
  }
  return cameras;
}

}  // namespace raygrid
