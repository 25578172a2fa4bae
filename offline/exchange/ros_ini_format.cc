#include "exchange/ros_ini_format.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <map>

#include "dataset/text_encoding.h"
#include "exchange/opencv_forms.h"
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

// Its keys under the names that the .yaml has.
ExchangeContents ReadRosIni(const ReadRequest& request) {
  const YAML::Node ini = ParseRosIni(request.text);
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
    root["distortion_model"] =
        d.IsSequence() && d.size() > 5 ? "rational_polynomial" : "plumb_bob";
  return ReadRosCamera(root, request);
}

std::string IniRows(const std::string& key, const std::vector<double>& numbers,
                    size_t columns) {
  std::string text = key;
  for (size_t k = 0; k < numbers.size(); ++k)
    text += (k % columns == 0 ? "\n" : " ") + RealText(numbers[k]);
  return text + "\n\n";
}

std::string WriteRosIni(const WriteRequest& request) {
  const WrittenLens& camera = request.cameras.front();
  const RosMatrices matrices = RosMatricesOf(camera);
  std::string name;  // of a section, which ends with the bracket
  for (const char c : Printable(camera.name))
    if (c != '[' && c != ']') name += c;
  std::string text = "# Camera intrinsics\n\n";
  if (camera.fit)
    text += fmt::format("# Fitted {}: {}\n\n", camera.lens.form->name,
                        LensFitText(*camera.fit));
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

Format RosIniFormat() {
  Format format;
  format.name = "ros-ini";
  format.holds =
      ".ini of ROS camera_calibration: plumb_bob or rational_polynomial; one "
      "file per camera of a rig, with R and P for a rectified pair";
  format.forms = {OpenCvForm("plumb_bob", 5),
                  OpenCvForm("rational_polynomial", 8)};
  format.ending = ".ini";
  format.holds_pairs = true;
  format.recognizes = IsRosIni;
  format.read = ReadRosIni;
  format.write = WriteRosIni;
  return format;
}

}  // namespace raygrid
