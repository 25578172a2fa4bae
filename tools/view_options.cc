#include "view_options.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <vector>

#include "camera_input.h"
#include "dataset/camera_file.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

struct ViewWord {
  const char* name;
  const char* value;  // what it takes
  const char* help;
};

constexpr ViewWord kViewWords[] = {
    {"hfov", "DEGREES",
     "horizontal field of view (default of all: as sharp in the middle as the "
     "image)"},
    {"vfov", "DEGREES", "vertical field of view"},
    {"focal", "PX", "focal length"},
    {"alpha", "0..1",
     "0: the largest view without border; 1: the smallest that shows every "
     "pixel of the area"},
    {"center", "X,Y",
     "where the view looks straight ahead, its principal point (default: the "
     "middle)"},
    {"like", "FILE", "as the view in a camera file, NAME.camera.yaml"},
};

// The word's numbers, as many as asked for.
std::vector<double> ViewNumbers(const std::string& place,
                                const std::string& text, size_t count) {
  std::vector<double> numbers;
  const char *at = text.data(), *const end = text.data() + text.size();
  while (numbers.size() < count) {
    double value = NAN;
    const auto [next, fault] = std::from_chars(at, end, value);
    if (fault != std::errc() || !std::isfinite(value)) break;
    numbers.push_back(value);
    at = next;
    if (at == end || *at != ',') break;
    ++at;
  }
  if (numbers.size() != count || at != end || text.back() == ',')
    throw Error(
        ExitCode::kUsage,
        fmt::format("{}: expected {}, not '{}'", place,
                    count == 1 ? "a number" : "two numbers, as 320,240", text));
  return numbers;
}

VirtualView ReadView(const std::string& place, const std::string& path) {
  const CameraInput input = ReadCamera(path);
  if (const auto view = ViewOfCamera(*input.file.camera)) return *view;
  throw Error(ExitCode::kUsage,
              fmt::format("{}: {} is no view: a camera of the model opencv "
                          "without distortion",
                          place, path));
}

void AddWord(const std::string& place, const std::string& name,
             const std::string& value, ViewRequest* request) {
  if (name == "like") {
    request->like = ReadView(place, value);
    return;
  }
  if (name == "center") {
    const std::vector<double> at = ViewNumbers(place, value, 2);
    request->center_px = Eigen::Vector2d(at[0], at[1]);
    return;
  }
  const double number = ViewNumbers(place, value, 1)[0];
  if (name == "hfov") request->hfov_deg = number;
  if (name == "vfov") request->vfov_deg = number;
  if (name == "focal") request->focal_px = number;
  if (name == "alpha") request->alpha = number;
}

bool IsViewWord(const std::string& name) {
  for (const ViewWord& word : kViewWords)
    if (name == word.name) return true;
  return false;
}

// Splits "640x480,center=3,4,hfov=90" at the commas before words.
std::vector<std::string> ViewParts(const std::string& text) {
  std::vector<std::string> parts;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    if (parts.size() > 0 && part.find('=') == std::string::npos)
      parts.back() += ',' + part;
    else
      parts.push_back(part);
    begin = end + 1;
  }
  return parts;
}

}  // namespace

const char kViewWordsHelp[] =
    "hfov=DEGREES, vfov=DEGREES, focal=PX, alpha=0..1 (0: the largest view "
    "without border; 1: the smallest that shows every pixel), center=X,Y (its "
    "principal point), like=FILE (a view's camera file)";

ViewRequest ParseView(const std::string& option, const std::string& text) {
  ViewRequest request;
  ViewWords seen;
  for (const std::string& part : ViewParts(text)) {
    const size_t equals = part.find('=');
    if (equals == std::string::npos && seen.empty() &&
        request.size.width == 0) {
      request.size = ParseImageSize(option, part);
      continue;
    }
    const std::string name = part.substr(0, equals);
    if (equals == std::string::npos || !IsViewWord(name))
      throw Error(ExitCode::kUsage,
                  fmt::format("{} {}: expected WIDTHxHEIGHT and {}, not '{}'",
                              option, text, kViewWordsHelp, part));
    if (!seen.emplace(name, "").second)
      throw Error(ExitCode::kUsage,
                  fmt::format("{} {}: {} stands twice", option, text, name));
    AddWord(fmt::format("{} {}: {}", option, text, name), name,
            part.substr(equals + 1), &request);
  }
  return request;
}

void AddViewOptions(CLI::App* command, ViewWords* words) {
  command->add_option("--size", (*words)["size"],
                      "WxH of the view (default: as the images)");
  for (const ViewWord& word : kViewWords)
    command
        ->add_option(std::string("--") + word.name, (*words)[word.name],
                     word.help)
        ->option_text(word.value);
}

ViewRequest ParseViewOptions(const ViewWords& words) {
  ViewRequest request;
  for (const auto& [name, value] : words) {
    if (value.empty()) continue;
    if (name == "size")
      request.size = ParseImageSize("--size", value);
    else
      AddWord("--" + name, name, value, &request);
  }
  return request;
}

std::string ViewText(const VirtualView& view) {
  return fmt::format(
      "{} x {} px, fx {:.6g}, fy {:.6g}, cx {:.6g}, cy {:.6g}, sees {:.1f} x "
      "{:.1f} degrees",
      view.size.width, view.size.height, view.focal_px.x(), view.focal_px.y(),
      view.center_px.x(), view.center_px.y(), view.HorizontalFieldOfViewDeg(),
      view.VerticalFieldOfViewDeg());
}

nlohmann::ordered_json ViewJson(const VirtualView& view) {
  return {{"projection", "pinhole"},
          {"size", {view.size.width, view.size.height}},
          {"K",
           {{view.focal_px.x(), 0.0, view.center_px.x()},
            {0.0, view.focal_px.y(), view.center_px.y()},
            {0.0, 0.0, 1.0}}},
          {"hfov_deg", view.HorizontalFieldOfViewDeg()},
          {"vfov_deg", view.VerticalFieldOfViewDeg()}};
}

std::string ViewCameraFile(const VirtualView& view, const std::string& name) {
  CameraFile file;
  file.camera = CameraOfView(view);
  file.name = name;
  return FormatCameraFile(file);
}

}  // namespace raygrid
