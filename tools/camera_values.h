/// Options that are specified once for each camera of a rig: NAME=VALUE.
#ifndef RAYGRID_TOOLS_CAMERA_VALUES_H
#define RAYGRID_TOOLS_CAMERA_VALUES_H

#include <string>
#include <vector>

namespace raygrid {

struct NamedValue {
  std::string name, value;
};

/// Images of a rig's camera; the name is empty for a single camera.
struct RigCameraImages {
  std::string camera;
  std::vector<std::string> images;
};

/// Splits NAME=VALUE at the '='; without one, the text is the value.
NamedValue ParseNamedValue(const std::string& text);

/// Requires letters, digits, '-' and '_', because names become folders and
/// fields of CSV files. Throws Error(kUsage).
void RequireCameraName(const std::string& name);

/// Parses the values of an option by camera name. Throws Error(kUsage) if a
/// name is missing or a duplicate. value_name is for messages: "FOLDER".
std::vector<NamedValue> ParseCameraValues(
    const std::string& option, const std::string& value_name,
    const std::vector<std::string>& texts);

/// Throws Error(kUsage) if two cameras have the same folder, even if the paths
/// differ: images cannot belong to both.
void RequireSeparateFolderNames(const std::string& option,
                                const std::vector<NamedValue>& folders);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CAMERA_VALUES_H
