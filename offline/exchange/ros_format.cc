#include "exchange/ros_format.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/camera_keys.h"
#include "exchange/file_storage.h"
#include "exchange/opencv_model_list.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kPlumbBob[] = "plumb_bob", kRational[] = "rational_polynomial",
               kEquidistant[] = "equidistant";

const std::vector<ExternalModel>& GetRosModels() {
  static const std::vector<ExternalModel> external_models = {
      MakeOpenCvModel(kPlumbBob, 5), MakeOpenCvModel(kRational, 8),
      MakeOpenCvFisheyeModel(kEquidistant)};
  return external_models;
}

// Returns the external model for the distortion model and number of
// coefficients of a file. Removes trailing zeros that the model does not have.
const ExternalModel& FindRosModel(const std::string& model,
                                  std::vector<double>* d) {
  static const ExternalModel twelve = MakeOpenCvModel(kRational, 12),
                             fourteen = MakeOpenCvModel(kRational, 14),
                             four = MakeOpenCvModel(kPlumbBob, 4),
                             none = MakeOpenCvModel(kPlumbBob, 0);
  const std::vector<ExternalModel>& external_models = GetRosModels();
  const std::string word = Lowercase(model);
  if (word.empty() || word == "none" || word == "pinhole") {
    TrimCoefficients(0, d);
    if (!d->empty())
      throw InputError(fmt::format(
          "unsupported distortion model '{}' with non-zero coefficients; use "
          "plumb_bob, rational_polynomial or equidistant",
          Printable(model)));
    return none;
  }
  if (word == kPlumbBob) {
    TrimCoefficients(5, d);
    return d->empty() ? none : d->size() == 4 ? four : external_models[0];
  }
  if (word == kRational) {
    TrimCoefficients(8, d);
    return d->size() == 12   ? twelve
           : d->size() == 14 ? fourteen
                             : external_models[1];
  }
  if (word == kEquidistant || word == "fisheye") {
    TrimCoefficients(4, d);
    return external_models[2];
  }
  throw InputError(
      fmt::format("unknown distortion model '{}'; use plumb_bob, "
                  "rational_polynomial or equidistant",
                  Printable(model)));
}

// Returns the distortion model, which early files store under another key;
// nullopt if missing.
std::optional<std::string> FindModelName(const CameraKeys& keys) {
  const bool has_model = keys.Has("distortion_model");
  const std::string camera = keys.Word("camera_model");
  if (has_model)
    return keys["distortion_model"].IsScalar() ? keys.Word("distortion_model")
                                               : "";
  if (!ParseModelFamily(camera)) return std::nullopt;
  keys.Skip({"camera_model"});
  return *ParseModelFamily(camera) == ModelFamily::kPinhole ? kPlumbBob
                                                            : camera;
}

// Returns a matrix: in files, a mapping with data; in messages, a list. nullopt
// if missing.
std::optional<std::vector<double>> FindRosMatrix(const CameraKeys& keys,
                                                 const std::string& in_files,
                                                 const std::string& in_messages,
                                                 int count) {
  for (const std::string& key :
       {in_files, in_messages, Lowercase(in_messages)}) {
    const YAML::Node matrix = keys[key];
    if (!matrix.IsDefined()) continue;
    const std::vector<double> numbers = AllNumbers(matrix, key);
    if (count >= 0 && static_cast<int>(numbers.size()) != count)
      throw InputError(
          fmt::format("{}: expected a list of {} numbers", key, count));
    return numbers;
  }
  return std::nullopt;
}

std::vector<double> ReadMatrix(const CameraKeys& keys, const char* in_files,
                               const char* in_messages, int count) {
  if (const auto matrix = FindRosMatrix(keys, in_files, in_messages, count))
    return *matrix;
  throw InputError(fmt::format("'{}' is missing", in_files));
}

// Returns the image size; 0 x 0 if missing.
ImageSize ReadRosSize(const CameraKeys& keys) {
  const char* const prefix =
      keys.Has("image_width") || keys.Has("image_height") ? "image_" : "";
  const auto get_side = [&](const std::string& side) {
    return SidePx(keys[prefix + side], prefix + side);
  };
  if (!keys.Has(fmt::format("{}width", prefix)) &&
      !keys.Has(fmt::format("{}height", prefix)))
    return {};
  return {get_side("width"), get_side("height")};
}

// Single cameras may lack R and P; if only one is missing, it gets the default
// of a single camera. A focal length of 0 in P means that both are unknown.
std::optional<RectifiedProjection> ReadRectifiedProjection(
    const CameraKeys& keys, const ConvertedCamera& lens) {
  const auto in_r = FindRosMatrix(keys, "rectification_matrix", "R", 9),
             in_p = FindRosMatrix(keys, "projection_matrix", "P", 12);
  if (!in_r && !in_p) return std::nullopt;
  if (in_p && (*in_p)[0] == 0 && (*in_p)[5] == 0) return std::nullopt;
  const std::vector<double>& k = lens.values;
  const std::vector<double> r =
      in_r.value_or(std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 1});
  const std::vector<double> p = in_p.value_or(
      std::vector<double>{k[0], 0, k[2], 0, 0, k[1], k[3], 0, 0, 0, 1, 0});
  RectifiedProjection rectified;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      rectified.r(row, column) = r[3 * row + column];
    for (int column = 0; column < 4; ++column)
      rectified.p(row, column) = p[4 * row + column];
  }
  PoseFromMatrix(
      {r[0], r[1], r[2], 0, r[3], r[4], r[5], 0, r[6], r[7], r[8], 0},
      "rectification_matrix");
  if (!(p[0] > 0 && p[5] > 0))
    throw InputError("projection_matrix: focal lengths must be positive");
  return rectified;
}

// Warns about binning and regions of interest at the time of the message.
void AddWarnings(const CameraKeys& keys, ExchangeContents* contents) {
  const auto is_set = [&](const char* key) {
    const std::string word = keys[key].IsDefined() ? keys.Word(key) : "";
    return !word.empty() && word != "0" && word != "1";
  };
  bool is_binned_or_cropped = false;
  for (const char* key : {"binning_x", "binning_y", "roi/x_offset",
                          "roi/y_offset", "roi/width", "roi/height"})
    is_binned_or_cropped = is_set(key) || is_binned_or_cropped;
  if (is_binned_or_cropped)
    contents->warnings.push_back(
        "binning and region of interest are ignored: the camera is that of the "
        "full frame");
  keys.Skip({"header", "roi", "camera_info_url"});
}

// Removes the "---" line that ends a printed message.
std::string FirstDocument(const std::string& text) {
  const size_t end = text.rfind("\n---");
  return end != std::string::npos &&
                 text.find_first_not_of("- \r\n", end + 1) == std::string::npos
             ? text.substr(0, end + 1)
             : text;
}

}  // namespace

ExchangeContents ReadRosCamera(const YAML::Node& root,
                               const ReadRequest& request) {
  const CameraKeys keys(root);
  ExchangeContents contents;
  InputCamera camera;
  camera.name = keys["camera_name"].IsDefined() ? keys.Word("camera_name") : "";
  camera.lens.size = ReadRosSize(keys);
  ReadCameraMatrix(ReadMatrix(keys, "camera_matrix", "K", 9), "camera_matrix",
                   &camera.lens);
  std::vector<double> d = ReadMatrix(keys, "distortion_coefficients", "D", -1);
  const auto in_file = FindModelName(keys);
  const std::string model = in_file.value_or(
      request.external_model.empty() ? kPlumbBob : request.external_model);
  camera.lens.external_model = &FindRosModel(model, &d);
  if (in_file) RequireModelOfFile(request, *camera.lens.external_model);
  camera.rectified = ReadRectifiedProjection(keys, camera.lens);
  camera.lens.values.insert(camera.lens.values.end(), d.begin(), d.end());
  AddWarnings(keys, &contents);
  keys.Finish(*camera.lens.external_model, &contents.warnings);
  contents.cameras.push_back(std::move(camera));
  return contents;
}

RosMatrices MakeRosMatrices(const OutputCamera& camera) {
  const ConvertedCamera& lens = camera.lens;
  const double fx = lens.Value("fx"), fy = lens.Value("fy"),
               cx = lens.Value("cx"), cy = lens.Value("cy");
  RosMatrices matrices = {{fx, 0, cx, 0, fy, cy, 0, 0, 1},
                          lens.ValuesFrom(4),
                          {1, 0, 0, 0, 1, 0, 0, 0, 1},
                          {fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0}};
  if (!camera.rectified) return matrices;
  for (int k = 0; k < 9; ++k) matrices.r[k] = camera.rectified->r(k / 3, k % 3);
  for (int k = 0; k < 12; ++k)
    matrices.p[k] = camera.rectified->p(k / 4, k % 4);
  return matrices;
}

namespace {

ExchangeContents ReadRos(const ReadRequest& request) {
  const std::string text = FirstDocument(request.text);
  return ReadRosCamera(LoadForeignMap(request.path, text), request);
}

bool IsRos(const std::string& text) {
  const auto has = [&](const char* word) {
    return text.find(word) != std::string::npos;
  };
  return !IsFileStorage(text) &&
         ((has("camera_matrix:") && has("distortion_coefficients:") &&
           has("data:")) ||
          (has("distortion_model:") && (has("\nK:") || has("\nk:")) &&
           (has("\nP:") || has("\np:"))));
}

std::string FormatMatrix(const char* name, int rows, int columns,
                         const std::vector<double>& data) {
  return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: [{}]\n", name, rows,
                     columns, RealTexts(data));
}

std::string WriteRos(const WriteRequest& request) {
  const OutputCamera& camera = request.cameras.front();
  const ConvertedCamera& lens = camera.lens;
  const RosMatrices matrices = MakeRosMatrices(camera);
  std::string text;
  if (camera.fit)
    text += fmt::format("# Fitted {}: {}\n", lens.external_model->name,
                        FormatModelFit(*camera.fit));
  text += fmt::format("image_width: {}\nimage_height: {}\n", lens.size.width,
                      lens.size.height);
  if (!camera.name.empty())
    text += fmt::format("camera_name: {}\n", QuotedYaml(camera.name));
  return text + FormatMatrix("camera_matrix", 3, 3, matrices.k) +
         fmt::format("distortion_model: {}\n", lens.external_model->name) +
         FormatMatrix("distortion_coefficients", 1,
                      static_cast<int>(matrices.d.size()), matrices.d) +
         FormatMatrix("rectification_matrix", 3, 3, matrices.r) +
         FormatMatrix("projection_matrix", 3, 4, matrices.p);
}

}  // namespace

Format MakeRosFormat() {
  Format format;
  format.name = "ros";
  format.holds =
      "camera_info .yaml: plumb_bob, rational_polynomial or equidistant; one "
      "file per camera of a rig, with R and P for a rectified pair";
  format.external_models = GetRosModels();
  format.supports_pairs = true;
  format.accepts_model = true;
  format.recognizes = IsRos;
  format.read = ReadRos;
  format.write = WriteRos;
  return format;
}

}  // namespace raygrid
