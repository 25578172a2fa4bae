#include "exchange/ros_ini_format.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <map>

#include "dataset/text_encoding.h"
#include "exchange/opencv_model_list.h"
#include "exchange/plain_trees.h"
#include "exchange/ros_format.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

bool IsRosIni(const std::string& text) {
  for (const char* word : {"[image]", "camera matrix", "distortion"})
    if (text.find(word) == std::string::npos) return false;
  return true;
}

// INI files do not state the model; the calibrator writes the five plumb_bob
// coefficients.
constexpr char kFourCoefficients[] = "equidistant";

// Renames INI keys to those of the .yaml format.
YAML::Node ParseRosIniTree(const std::string& text) {
  const YAML::Node ini = ParseRosIni(text);
  const std::map<std::string, std::string> names = {
      {"width", "image_width"},
      {"height", "image_height"},
      {"name", "camera_name"},
      {"camera matrix", "camera_matrix"},
      {"distortion", "distortion_coefficients"},
      {"rectification", "rectification_matrix"},
      {"projection", "projection_matrix"}};
  YAML::Node root(YAML::NodeType::Map);
  for (const auto& entry : ini) {
    const std::string key = entry.first.as<std::string>();
    const auto name = names.find(key);
    root.force_insert(name == names.end() ? key : name->second, entry.second);
  }
  const YAML::Node d = root["distortion_coefficients"];
  if (d.IsDefined())
    root["distortion_model"] = !d.IsSequence() ? "plumb_bob"
                               : d.size() > 5  ? "rational_polynomial"
                               : d.size() == 4 ? kFourCoefficients
                                               : "plumb_bob";
  return root;
}

// Reads consecutive cameras, as in the calibrator's ost.txt of a stereo pair;
// preceding output is skipped.
ExchangeContents ReadRosIni(const ReadRequest& request) {
  const std::string& text = request.text;
  const std::string image = "[image]";
  size_t at = text[0] == '[' ? 0 : std::min(text.find("\n["), text.size());
  ExchangeContents all;
  for (size_t end = 0; end < text.size(); at = end) {
    const size_t first = std::min(text.find(image, at), text.size());
    end = std::min(text.find(image, first + 1), text.size());
    const auto lines = std::count(text.begin(), text.begin() + at, '\n');
    ExchangeContents one = ReadRosCamera(
        ParseRosIniTree(std::string(lines, '\n') + text.substr(at, end - at)),
        request);
    if (one.cameras.front().lens.external_model->name == kFourCoefficients)
      one.warnings.push_back(
          "assuming the fisheye model equidistant, of which ROS writes four "
          "coefficients");
    all.cameras.push_back(std::move(one.cameras.front()));
    all.warnings.insert(all.warnings.end(), one.warnings.begin(),
                        one.warnings.end());
  }
  if (all.cameras.size() > 1) {
    for (InputCamera& camera :
         all.cameras)  // "narrow_stereo/left" becomes "left"
      camera.name.erase(0, camera.name.rfind('/') + 1);
    ComputeStereoPoses(&all.cameras);
  }
  return all;
}

std::string IniRows(const std::string& key, const std::vector<double>& numbers,
                    size_t columns) {
  std::string text = key;
  for (size_t k = 0; k < numbers.size(); ++k)
    text += (k % columns == 0 ? "\n" : " ") + FormatReal(numbers[k]);
  return text + "\n\n";
}

std::string WriteRosIni(const WriteRequest& request) {
  const OutputCamera& camera = request.cameras.front();
  const RosMatrices matrices = MakeRosMatrices(camera);
  std::string name;  // section names must not contain brackets
  for (const char c : Printable(camera.name))
    if (c != '[' && c != ']') name += c;
  std::string text = "# Camera intrinsics\n\n";
  if (camera.fit)
    text += fmt::format("# Fitted {}: {}\n\n", camera.lens.external_model->name,
                        FormatModelFit(*camera.fit));
  return text +
         fmt::format("[image]\n\nwidth\n{}\n\nheight\n{}\n\n[{}]\n\n",
                     camera.lens.size.width, camera.lens.size.height,
                     name.empty() ? "camera" : name) +
         IniRows("camera matrix", matrices.k, 3) +
         IniRows("distortion", matrices.d, matrices.d.size()) +
         IniRows("rectification", matrices.r, 3) +
         IniRows("projection", matrices.p, 4);
}

}  // namespace

Format MakeRosIniFormat() {
  Format format;
  format.name = "ros-ini";
  format.holds =
      ".ini of ROS camera_calibration: plumb_bob or rational_polynomial; one "
      "file per camera of a rig, with R and P for a rectified pair";
  format.external_models = {MakeOpenCvModel("plumb_bob", 5),
                            MakeOpenCvModel("rational_polynomial", 8)};
  format.ending = ".ini";
  format.supports_pairs = true;
  format.recognizes = IsRosIni;
  format.read = ReadRosIni;
  format.write = WriteRosIni;
  return format;
}

}  // namespace raygrid
