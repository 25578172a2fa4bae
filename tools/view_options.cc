#include "view_options.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "camera_input.h"
#include "dataset/camera_file.h"
#include "dataset/error.h"
#include "help_formatter.h"
#include "image_size_option.h"
#include "key_options.h"

namespace raygrid {
namespace {

struct ViewKey {
  const char* name;
  const char* value;  // placeholder of the option's value
  const char* help;
};

constexpr ViewKey kViewKeys[] = {
    {"hfov", "DEG",
     "horizontal field of view (default: same resolution as the image at its "
     "centre)"},
    {"vfov", "DEG", "vertical field of view"},
    {"focal", "PX", "focal length"},
    {"alpha", "0..1",
     "0: largest view that contains valid pixels only; 1: smallest view that "
     "contains all pixels"},
    {"center", "X,Y", "principal point in px (default: image centre)"},
    {"projection", "NAME",
     "pinhole, cylindrical, equirectangular, stereographic or equidistant"},
    {"rotate", "YAW,PITCH,ROLL",
     "rotation of the output view in degrees (positive: right, up, clockwise)"},
    {"view", "FILE",
     "camera file of the output view, such as NAME.camera.yaml"},
};

VirtualView ReadView(const std::string& place, const std::string& path) {
  const CameraInput input = ReadCamera(path);
  auto view = MakeCameraView(*input.file.camera);
  if (!view)
    throw Error(ExitCode::kUsage,
                fmt::format("{}: {} is not a view (an undistorted opencv "
                            "camera, or one with a projection)",
                            place, path));
  if (input.file.camera_from_view)
    view->camera_from_view =
        input.file.camera_from_view->rotation.toRotationMatrix();
  return *view;
}

ViewProjection ParseProjection(const std::string& place,
                               const std::string& text) {
  if (const auto projection = FindProjection(text)) return *projection;
  throw Error(ExitCode::kUsage,
              fmt::format("{}: expected pinhole, cylindrical, equirectangular, "
                          "stereographic or equidistant, not '{}'",
                          place, text));
}

void AddKey(const std::string& place, const std::string& name,
            const std::string& value, ViewRequest* request) {
  if (name == "view") {
    request->like = ReadView(place, value);
    return;
  }
  if (name == "center") {
    const std::vector<double> at = ParseNumbers(place, value, 2, "320,240");
    request->center_px = Eigen::Vector2d(at[0], at[1]);
    return;
  }
  if (name == "rotate") {
    const std::vector<double> angles =
        ParseNumbers(place, value, 3, "30,-10,0");
    request->rotate_deg = Eigen::Vector3d(angles[0], angles[1], angles[2]);
    return;
  }
  if (name == "projection") {
    request->projection = ParseProjection(place, value);
    return;
  }
  const double number = ParseNumbers(place, value, 1, "90")[0];
  if (name == "hfov") request->hfov_deg = number;
  if (name == "vfov") request->vfov_deg = number;
  if (name == "focal") request->focal_px = number;
  if (name == "alpha") request->alpha = number;
}

bool IsViewKey(const std::string& name) {
  for (const ViewKey& key : kViewKeys)
    if (name == key.name) return true;
  return false;
}

}  // namespace

const char kViewSyntaxHelp[] =
    "Views, WxH and any of these after commas:\n"
    "  hfov=DEG, vfov=DEG, focal=PX   field of view or focal length\n"
    "  alpha=0..1                     0: valid pixels only; 1: all pixels\n"
    "  center=X,Y                     principal point\n"
    "  rotate=YAW,PITCH,ROLL          degrees right, up, clockwise\n"
    "  projection=NAME                pinhole, cylindrical, equirectangular,\n"
    "                                 stereographic, equidistant\n"
    "  view=FILE                      camera file of another view\n"
    "  direction=distort              inverse remap: render frames from the "
    "view\n"
    "  at=M or plane=NX,NY,NZ,M       distance or plane of the scene, for\n"
    "                                 non-central cameras\n";

const char kViewKeysHelp[] =
    "hfov=DEG, vfov=DEG, focal=PX, alpha=0..1 (0: valid pixels only; 1: all "
    "pixels), center=X,Y (principal point), rotate=YAW,PITCH,ROLL (degrees "
    "right, up, clockwise), "
    "projection=pinhole|cylindrical|equirectangular|stereographic|equidistant, "
    "view=FILE (another view's camera file)";

ViewRequest ParseView(const std::string& option, const std::string& text) {
  ViewRequest request;
  ViewKeyValues seen;
  for (const std::string& part : SplitAtKeys(text)) {
    const size_t equals = part.find('=');
    if (equals == std::string::npos && seen.empty() &&
        request.size.width == 0) {
      request.size = ParseImageSize(option, part);
      continue;
    }
    std::string name = part.substr(0, equals);
    if (name == "like") name = "view";  // former name
    if (equals == std::string::npos || !IsViewKey(name))
      throw Error(ExitCode::kUsage,
                  fmt::format("{} {}: expected WIDTHxHEIGHT and {}, not '{}'",
                              option, text, kViewKeysHelp, part));
    if (!seen.emplace(name, "").second)
      throw Error(ExitCode::kUsage, fmt::format("{} {}: {} is specified twice",
                                                option, text, name));
    AddKey(fmt::format("{} {}: {}", option, text, name), name,
           part.substr(equals + 1), &request);
  }
  RequireValidView(request);
  return request;
}

const char kTableKeysHelp[] =
    "direction=distort (inverse remap, from undistorted images to frames), and "
    "for non-central cameras at=METRES (distance of the scene) or "
    "plane=NX,NY,NZ,METRES (plane of the scene, in camera axes)";

namespace {

SceneSurface ParseScene(const std::string& place, const std::string& name,
                        const std::string& value) {
  SceneSurface scene;
  if (name == "at") {
    scene.distance_m = ParseNumbers(place, value, 1, "0.8")[0];
  } else {
    const std::vector<double> numbers =
        ParseNumbers(place, value, 4, "0,0,1,0.8");
    const Eigen::Vector3d normal(numbers[0], numbers[1], numbers[2]);
    scene.normal = normal.normalized();
    scene.distance_m = numbers[3] / normal.norm();
    if (!(normal.norm() > 0 && scene.normal->allFinite()))
      throw Error(
          ExitCode::kUsage,
          fmt::format("{}: expected a non-zero normal and a distance, not '{}'",
                      place, value));
  }
  if (!(scene.distance_m > 0 && std::isfinite(scene.distance_m)))
    throw Error(ExitCode::kUsage,
                fmt::format("{}: expected a positive distance, not '{}'", place,
                            value));
  return scene;
}

// Parses a key that applies to remap tables only; returns false if it is a key
// of views.
bool AddTableKey(const std::string& option, const std::string& text,
                 const std::string& part, RemapKeys* words) {
  const size_t equals = part.find('=');
  if (equals == std::string::npos) return false;
  const std::string name = part.substr(0, equals);
  const std::string value = part.substr(equals + 1);
  const std::string place = fmt::format("{} {}: {}", option, text, name);
  if (name == "direction") {
    if (value != "distort" && value != "undistort")
      throw Error(ExitCode::kUsage,
                  fmt::format("{}: expected undistort or distort, not '{}'",
                              place, value));
    words->distorts = value == "distort";
    return true;
  }
  if (name != "at" && name != "plane") return false;
  if (words->scene)
    throw Error(ExitCode::kUsage,
                fmt::format("{} {}: at and plane are mutually exclusive; "
                            "specify only one, and only once",
                            option, text));
  words->scene = ParseScene(place, name, value);
  return true;
}

}  // namespace

RemapKeys ParseRemap(const std::string& option, const std::string& text) {
  RemapKeys words;
  std::string view;
  for (const std::string& part : SplitAtKeys(text))
    if (!AddTableKey(option, text, part, &words))
      view += (view.empty() ? "" : ",") + part;
  if (!view.empty() || text.empty()) words.view = ParseView(option, view);
  return words;
}

void AddViewOptions(CLI::App* command, ViewKeyValues* words) {
  BeginGroup(command, help_group::kView);
  command
      ->add_option(
          "--size", (*words)["size"],
          "size of the undistorted view in px (default: that of the images)")
      ->option_text("WxH");
  for (const ViewKey& key : kViewKeys)
    command
        ->add_option(std::string("--") + key.name, (*words)[key.name], key.help)
        ->option_text(key.value);
}

void AddOutsideOption(CLI::App* command, std::string* outside) {
  command
      ->add_option("--outside", *outside,
                   "outside the valid region: extrapolate the camera model "
                   "(fill) or use the border value (border)")
      ->transform([](const std::string& value) -> std::string {
        return value == "trusted" ? "border" : value;  // former name
      })
      ->check(CLI::IsMember({"fill", "border"}))
      ->option_text("fill|border")
      ->group(help_group::kView)
      ->capture_default_str();
}

ViewRequest ParseViewOptions(const ViewKeyValues& words) {
  ViewRequest request;
  for (const auto& [name, value] : words) {
    if (value.empty()) continue;
    if (name == "size")
      request.size = ParseImageSize("--size", value);
    else
      AddKey("--" + name, name, value, &request);
  }
  RequireValidView(request);
  return request;
}

std::string FirstToken(const ViewKeyValues& words) {
  for (const auto& [name, value] : words)
    if (!value.empty()) return name;
  return "";
}

VirtualView RectifiedView(const CameraInput& input,
                          const ViewKeyValues& words) {
  const bool is_given = !FirstToken(words).empty();
  const std::vector<uint32_t> tables =
      input.blob ? input.blob->ListCalibratedTables() : std::vector<uint32_t>();
  if (!is_given && !tables.empty())
    return input.blob->GetRemapView(tables.front());
  return is_given ? MakeView(*input.file.camera, ParseViewOptions(words))
                  : MakeAreaView(*input.file.camera);
}

Eigen::Vector3d ViewAnglesDeg(const Eigen::Matrix3d& camera_from_view) {
  const Eigen::Vector3d angles = RotationToAngles(camera_from_view);
  return (1e6 * angles).array().round() / 1e6 + 0.0;
}

std::string FormatView(const VirtualView& view) {
  std::string text = fmt::format(
      "{} x {} px, fx {:.6g}, fy {:.6g}, cx {:.6g}, cy {:.6g}, field of view "
      "{:.1f} x {:.1f} degrees",
      view.size.width, view.size.height, view.focal_px.x(), view.focal_px.y(),
      view.center_px.x(), view.center_px.y(), view.HorizontalFieldOfViewDeg(),
      view.VerticalFieldOfViewDeg());
  if (view.projection != ViewProjection::kPinhole)
    text += fmt::format(", {}", ProjectionName(view.projection));
  if (view.IsTurned()) {
    const Eigen::Vector3d angles = ViewAnglesDeg(view.camera_from_view);
    text += fmt::format(
        ", rotated {:.6g} degrees right, {:.6g} up, {:.6g} clockwise",
        angles[0], angles[1], angles[2]);
  }
  return text;
}

Eigen::Matrix3d GetCameraMatrix(const VirtualView& view) {
  Eigen::Matrix3d matrix;
  matrix << view.focal_px.x(), 0, view.center_px.x(), 0, view.focal_px.y(),
      view.center_px.y(), 0, 0, 1;
  return matrix;
}

nlohmann::ordered_json MakeViewJson(const VirtualView& view) {
  nlohmann::ordered_json rotation = nlohmann::json::array();
  for (int row = 0; row < 3; ++row)
    rotation.push_back({view.camera_from_view(row, 0),
                        view.camera_from_view(row, 1),
                        view.camera_from_view(row, 2)});
  return {{"projection", ProjectionName(view.projection)},
          {"size", {view.size.width, view.size.height}},
          {"K",
           {{view.focal_px.x(), 0.0, view.center_px.x()},
            {0.0, view.focal_px.y(), view.center_px.y()},
            {0.0, 0.0, 1.0}}},
          {"camera_from_view", rotation},
          {"hfov_deg", view.HorizontalFieldOfViewDeg()},
          {"vfov_deg", view.VerticalFieldOfViewDeg()}};
}

}  // namespace raygrid
