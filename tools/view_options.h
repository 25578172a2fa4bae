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

/// A view that is asked for, in words as they were typed: "hfov" and "90".
using ViewWords = std::map<std::string, std::string>;

/// The words of a view, for messages.
extern const char kViewWordsHelp[];
/// The syntax of --remap, a block of help.
extern const char kViewSyntaxHelp[];

/// "640x480", "640x480,hfov=90", "alpha=0,center=320,240": a size, words, or
/// both, with commas between. Throws Error(kUsage), naming the option.
ViewRequest ParseView(const std::string& option, const std::string& text);

/// A table that is asked for: a view, and what else a table may be told.
struct RemapWords {
  ViewRequest view;
  std::optional<SceneSurface> scene;
  bool distorts = false;
};

/// The words that only tables have, for messages.
extern const char kTableWordsHelp[];

/// ParseView(), with the words direction, at and plane as well.
RemapWords ParseRemap(const std::string& option, const std::string& text);

/// Adds --size and an option for each word of a view.
void AddViewOptions(CLI::App* command, ViewWords* words);
/// Adds --outside: "fill" or "border".
void AddOutsideOption(CLI::App* command, std::string* outside);
/// The view that those options ask for; throws Error(kUsage).
ViewRequest ParseViewOptions(const ViewWords& words);

/// The name of a word that was given, or "".
std::string FirstWord(const ViewWords& words);
/// The view that undistorted images of a camera have: that of a blob's table,
/// the one that is asked for, or that which calibrate makes a table of.
VirtualView RectifiedView(const CameraInput& input, const ViewWords& words);

/// "640 x 480 px, fx 300.5, fy 300.5, cx 319.5, cy 239.5, sees 93.6 x 77.2
/// degrees", and the projection and the angles of what is no pinhole or turned.
std::string ViewText(const VirtualView& view);
/// Yaw, pitch and roll of a view; nothing is left of an angle of 0 by rounding.
Eigen::Vector3d ViewAnglesDeg(const Eigen::Matrix3d& camera_from_view);

/// K of a view: focal lengths and centre.
Eigen::Matrix3d MatrixOf(const VirtualView& view);
/// Size, projection, K and rotation row by row, and fields of view in degrees.
nlohmann::ordered_json ViewJson(const VirtualView& view);

/// The text of a camera file for a view of the camera of this name.
std::string ViewCameraFile(const VirtualView& view, const std::string& name);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_VIEW_OPTIONS_H
