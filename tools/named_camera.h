/// Options that are given once for each camera of a rig: NAME=VALUE.
#ifndef RAYGRID_TOOLS_NAMED_CAMERA_H
#define RAYGRID_TOOLS_NAMED_CAMERA_H

#include <string>
#include <vector>

namespace raygrid {

struct NamedValue {
  std::string name, value;
};

/// The texts before and after the '=' of NAME=VALUE; all is value without one.
NamedValue ParseNamedValue(const std::string& text);

/// Names become folders and fields of CSV files: letters, digits, '-' and '_'.
/// Throws Error(kUsage).
void RequireCameraName(const std::string& name);

/// The values of an option by the cameras' names. Throws Error(kUsage): one
/// without a name, two of one name. value_name is for messages: "FOLDER".
std::vector<NamedValue> ParseNamedCameras(
    const std::string& option, const std::string& value_name,
    const std::vector<std::string>& texts);

/// Throws Error(kUsage) if two values are one folder, by whatever path: its
/// images cannot be those of both.
void RequireDifferentFolders(const std::string& option,
                             const std::vector<NamedValue>& folders);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_NAMED_CAMERA_H
