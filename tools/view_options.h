#ifndef RAYGRID_TOOLS_VIEW_OPTIONS_H
#define RAYGRID_TOOLS_VIEW_OPTIONS_H

#include <CLI/CLI.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "camera/equivalent_central_camera.h"
#include "camera_input.h"
#include "packing/view_request.h"

namespace raygrid {

/// Keys and values of a requested view, such as "hfov" and "90".
using ViewKeyValues = std::map<std::string, std::string>;

/// Keys of a view, for messages.
extern const char kViewKeysHelp[];
/// Help block with the syntax of --remap.
extern const char kViewSyntaxHelp[];

/// Parses a size, key=value pairs, or both, separated by commas: "640x480",
/// "640x480,hfov=90", "alpha=0,center=320,240". Throws Error(kUsage).
ViewRequest ParseView(const std::string& option, const std::string& text);

/// A requested remap table: a view, and keys for tables only.
struct RemapKeys {
  ViewRequest view;
  std::optional<SceneSurface> scene;
  bool distorts = false;
};

/// Help text: the keys that only remap tables accept.
extern const char kTableKeysHelp[];

/// Like ParseView(), but also accepts the keys direction, at and plane.
RemapKeys ParseRemap(const std::string& option, const std::string& text);

/// Adds --size and an option for each key of a view.
void AddViewOptions(CLI::App* command, ViewKeyValues* words);
/// Adds --outside: "fill" or "border".
void AddOutsideOption(CLI::App* command, std::string* outside);
/// Parses the options of AddViewOptions(). Throws Error(kUsage).
ViewRequest ParseViewOptions(const ViewKeyValues& words);

/// Returns the name of a key that was specified, or "".
std::string FirstToken(const ViewKeyValues& words);
/// Returns the view of a camera's undistorted images: of the blob's table, as
/// requested, or the default view of calibrate.
VirtualView RectifiedView(const CameraInput& input, const ViewKeyValues& words);

/// Formats a view: "640 x 480 px, fx 300.5, fy 300.5, cx 319.5, cy 239.5, sees
/// 93.6 x 77.2 degrees", plus the projection if not pinhole, and the angles.
std::string FormatView(const VirtualView& view);
/// Returns yaw, pitch and roll of a view; angles of rounding size become 0.
Eigen::Vector3d ViewAnglesDeg(const Eigen::Matrix3d& camera_from_view);

/// Returns K of a view: focal lengths and principal point.
Eigen::Matrix3d GetCameraMatrix(const VirtualView& view);
/// Formats size, projection, K, row-major rotation, fields of view in degrees.
nlohmann::ordered_json MakeViewJson(const VirtualView& view);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_VIEW_OPTIONS_H
