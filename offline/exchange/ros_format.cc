#include "exchange/ros_format.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "dataset/yaml_file.h"
#include "exchange/file_storage.h"
#include "exchange/opencv_forms.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kPlumbBob[] = "plumb_bob", kRational[] = "rational_polynomial",
               kEquidistant[] = "equidistant";

const std::vector<LensForm>& RosForms() {
  static const std::vector<LensForm> forms = {OpenCvForm(kPlumbBob, 5),
                                              OpenCvForm(kRational, 8),
                                              OpenCvFisheyeForm(kEquidistant)};
  return forms;
}

// OpenCV's models of more coefficients, which drivers call rational_polynomial,
// and of fewer.
const LensForm& FormOfDistortion(const std::string& model, size_t count) {
  static const LensForm twelve = OpenCvForm(kRational, 12),
                        fourteen = OpenCvForm(kRational, 14),
                        four = OpenCvForm(kPlumbBob, 4),
                        none = OpenCvForm(kPlumbBob, 0);
  const std::vector<LensForm>& forms = RosForms();
  if (model == kPlumbBob)
    return count == 0 ? none : count == 4 ? four : forms[0];
  if (model == kRational)
    return count == 12 ? twelve : count == 14 ? fourteen : forms[1];
  if (model == kEquidistant) return forms[2];
  throw InputError(fmt::format(
      "unknown distortion model '{}'; ROS has plumb_bob, rational_polynomial "
      "and equidistant",
      Printable(model)));
}

// Matrices of files have a list of data; those of messages are the list.
std::vector<double> MatrixOf(const YAML::Node& root, const char* in_files,
                             const char* in_messages, int count) {
  if (const YAML::Node matrix = root[in_files])
    return FiniteNumbers(matrix["data"], in_files, count);
  for (const std::string& key :
       {std::string(in_messages), Lowercase(in_messages)})
    if (const YAML::Node list = root[key])
      return FiniteNumbers(list, key, count);
  throw InputError(fmt::format("'{}' is missing", in_files));
}

int SideOf(const YAML::Node& root, const char* in_files,
           const char* in_messages) {
  return root[in_files] ? SidePx(root[in_files], in_files)
                        : SidePx(root[in_messages], in_messages);
}

RectifiedProjection RectifiedOf(const YAML::Node& root) {
  const std::vector<double> r = MatrixOf(root, "rectification_matrix", "R", 9),
                            p = MatrixOf(root, "projection_matrix", "P", 12);
  RectifiedProjection rectified;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      rectified.r(row, column) = r[3 * row + column];
    for (int column = 0; column < 4; ++column)
      rectified.p(row, column) = p[4 * row + column];
  }
  PoseOfMatrix({r[0], r[1], r[2], 0, r[3], r[4], r[5], 0, r[6], r[7], r[8], 0},
               "rectification_matrix");
  if (!(p[0] > 0 && p[5] > 0))
    throw InputError("projection_matrix: a focal length is not above 0");
  return rectified;
}

// Parts of frames that a driver had when the message was printed.
void AddRemarks(const YAML::Node& root, ExchangeContents* contents) {
  const YAML::Node roi = root["roi"];
  const auto is_set = [](const YAML::Node& node) {
    return node.IsDefined() && node.IsScalar() &&
           node.as<std::string>() != "0" && node.as<std::string>() != "1";
  };
  if (is_set(root["binning_x"]) || is_set(root["binning_y"]) ||
      (roi.IsDefined() && roi.IsMap() &&
       (is_set(roi["x_offset"]) || is_set(roi["y_offset"]) ||
        is_set(roi["width"]) || is_set(roi["height"]))))
    contents->remarks.push_back(
        "its binning and region of interest are not taken: the camera is that "
        "of the whole frame");
}

// The text without the line that ends a printed message.
std::string FirstDocument(const std::string& text) {
  const size_t end = text.rfind("\n---");
  return end != std::string::npos &&
                 text.find_first_not_of("- \r\n", end + 1) == std::string::npos
             ? text.substr(0, end + 1)
             : text;
}

ExchangeContents ReadRos(const ReadRequest& request) {
  const std::string text = FirstDocument(request.text);
  RequireYamlFile(request.path, text);
  const YAML::Node root = YAML::Load(text);
  if (!root.IsMap()) throw InputError("no camera_info: no map of keys");
  ExchangeContents contents;
  ReadLens camera;
  if (root["camera_name"]) camera.name = root["camera_name"].as<std::string>();
  camera.lens.size =
      request.size.value_or(ImageSize{SideOf(root, "image_width", "width"),
                                      SideOf(root, "image_height", "height")});
  const std::vector<double> k = MatrixOf(root, "camera_matrix", "K", 9);
  if (k[1] != 0)
    throw InputError(fmt::format(
        "camera_matrix: a skew of {:g}, which no model here has", k[1]));
  if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    throw InputError("camera_matrix: not fx 0 cx, 0 fy cy, 0 0 1");
  const std::vector<double> d =
      MatrixOf(root, "distortion_coefficients", "D", -1);
  const std::string model = !request.form.empty() ? request.form
                            : root["distortion_model"]
                                ? root["distortion_model"].as<std::string>()
                                : kPlumbBob;
  camera.lens.form = &FormOfDistortion(model, d.size());
  camera.lens.values = {k[0], k[4], k[2], k[5]};
  camera.lens.values.insert(camera.lens.values.end(), d.begin(), d.end());
  camera.rectified = RectifiedOf(root);
  AddRemarks(root, &contents);
  contents.cameras.push_back(std::move(camera));
  return contents;
}

bool IsRos(const std::string& text) {
  const auto has = [&](const char* word) {
    return text.find(word) != std::string::npos;
  };
  return !IsFileStorage(text) &&
         ((has("camera_matrix:") && has("distortion_coefficients:")) ||
          (has("distortion_model:") && (has("\nK:") || has("\nk:")) &&
           (has("\nP:") || has("\np:"))));
}

std::string MatrixText(const char* name, int rows, int columns,
                       const std::vector<double>& data) {
  return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: [{}]\n", name, rows,
                     columns, RealTexts(data));
}

std::string WriteRos(const WriteRequest& request) {
  const WrittenLens& camera = request.cameras.front();
  const LensInForm& lens = camera.lens;
  const double fx = lens.Value("fx"), fy = lens.Value("fy"),
               cx = lens.Value("cx"), cy = lens.Value("cy");
  std::vector<double> r = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                      p = {fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0};
  if (camera.rectified) {
    for (int k = 0; k < 9; ++k) r[k] = camera.rectified->r(k / 3, k % 3);
    for (int k = 0; k < 12; ++k) p[k] = camera.rectified->p(k / 4, k % 4);
  }
  const std::vector<double> d = lens.ValuesFrom(4);
  std::string text;
  if (camera.fit)
    text += fmt::format("# The nearest {}: {}\n", lens.form->name,
                        LensFitText(*camera.fit));
  text += fmt::format("image_width: {}\nimage_height: {}\n", lens.size.width,
                      lens.size.height);
  if (!camera.name.empty())
    text += fmt::format("camera_name: {}\n", QuotedYaml(camera.name));
  return text +
         MatrixText("camera_matrix", 3, 3, {fx, 0, cx, 0, fy, cy, 0, 0, 1}) +
         fmt::format("distortion_model: {}\n", lens.form->name) +
         MatrixText("distortion_coefficients", 1, static_cast<int>(d.size()),
                    d) +
         MatrixText("rectification_matrix", 3, 3, r) +
         MatrixText("projection_matrix", 3, 4, p);
}

}  // namespace

Format RosFormat() {
  Format format;
  format.name = "ros";
  format.holds =
      "camera_info .yaml: plumb_bob, rational_polynomial or equidistant; of a "
      "rig a file for each camera, of a pair with R and P";
  format.forms = RosForms();
  format.holds_pairs = true;
  format.recognizes = IsRos;
  format.read = ReadRos;
  format.write = WriteRos;
  return format;
}

}  // namespace raygrid
