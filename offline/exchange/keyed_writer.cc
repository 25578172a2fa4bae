#include "exchange/keyed_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/raygrid_json.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

// ---- A camera as a tree ----------------------------------------------------

// Sets the value at a key path with nested mappings: "a/b".
void SetValueAtPath(const std::string& path, Json value, Json* map) {
  Json* place = map;
  for (const std::string& key : SplitText(path, '/')) place = &(*place)[key];
  *place = std::move(value);
}

// Returns the key that is written: the first of "KEY|KEY".
std::string FirstKey(const std::string& keys) {
  return keys.substr(0, keys.find('|'));
}

Json MakeMatrixRows(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    rows.push_back(Json::array());
    for (Eigen::Index column = 0; column < matrix.cols(); ++column)
      rows.back().push_back(matrix(row, column));
  }
  return rows;
}

Json MakeFlatMatrix(const Eigen::MatrixXd& matrix) {
  Json numbers = Json::array();
  for (const Json& row : MakeMatrixRows(matrix))
    for (const Json& number : row) numbers.push_back(number);
  return numbers;
}

// Line-based formats store matrices as flat lists.
Json MakeMatrixJson(const KeyedFormat& format, const Eigen::MatrixXd& matrix) {
  return format.syntax == KeyedSyntax::kLines ? MakeFlatMatrix(matrix)
                                              : MakeMatrixRows(matrix);
}

const KeyedModel& GetKeyedModel(const KeyedFormat& format,
                                const ExternalModel& external_model) {
  return *std::find_if(
      format.models.begin(), format.models.end(), [&](const KeyedModel& model) {
        return model.external_model.name == external_model.name;
      });
}

double GetValueInFile(const KeyedFormat& format, const ConvertedCamera& lens,
                      const std::string& parameter) {
  const double value = lens.Value(parameter);
  const bool is_length = parameter[0] == 'f' || parameter[0] == 'c';
  return format.unit == LengthUnit::kLongerSide && is_length
             ? value / std::max(lens.size.width, lens.size.height)
             : value;
}

void AddSize(const KeyedFormat& format, const ImageSize& size,
             const std::string& word, Json* map) {
  const std::vector<std::string> keys =
      SplitText(SubstituteCameraName(format.size, word));
  if (keys.size() == 1)
    SetValueAtPath(FirstKey(keys[0]), Json::array({size.width, size.height}),
                   map);
  if (keys.size() != 2) return;
  SetValueAtPath(FirstKey(keys[0]), size.width, map);
  SetValueAtPath(FirstKey(keys[1]), size.height, map);
}

void AddModel(const KeyedModel& model, Json* map) {
  for (const std::string& condition : SplitText(model.model_selector)) {
    const KeyWithMark said = SplitAtMark(condition, '?', "");
    const std::string word = FirstKey(said.words);
    if (word == "true" || word == "false")
      SetValueAtPath(said.key, word == "true", map);
    else
      SetValueAtPath(said.key, word, map);
  }
}

// Removes trailing zeros from lists of variable length. Programs require at
// least four coefficients; in line-based formats, the four intrinsics precede
// them and may be alone.
void TrimTrailingValues(bool is_line, std::vector<double>* numbers) {
  constexpr size_t kCoefficients = 4, kMatrix = 4;
  const size_t min_count = is_line ? kMatrix + kCoefficients : kCoefficients;
  while (numbers->size() > min_count && numbers->back() == 0)
    numbers->pop_back();
  if (is_line && numbers->size() == min_count &&
      std::all_of(numbers->begin() + kMatrix, numbers->end(),
                  [](double number) { return number == 0; }))
    numbers->resize(kMatrix);
}

// Returns the projection matrix of a rectified camera, or K [I t] of a camera
// that is parallel to the first one.
Eigen::MatrixXd MakeProjectionMatrix(const OutputCamera& camera,
                                     const Eigen::Matrix3d& k) {
  if (camera.rectified) return camera.rectified->p;
  constexpr double kMaxRotationRad = 1e-9;
  const Pose pose = camera.camera_from_rig.value_or(Pose{});
  if (pose.rotation.angularDistance(Eigen::Quaterniond::Identity()) >
      kMaxRotationRad)
    throw InputError(
        "the cameras are rotated relative to each other, but projection "
        "matrices require a rectified pair: export the rectified.yaml of "
        "raygrid rectify");
  Eigen::Matrix<double, 3, 4> p;
  p << k, k * pose.translation;
  return p;
}

void AddValues(const KeyedFormat& format, const KeyedModel& model,
               const OutputCamera& camera, const std::string& word, Json* map) {
  const ConvertedCamera& lens = camera.lens;
  for (const std::string& entry : SplitText(model.values)) {
    const bool may_be_missing = entry.find("?=") != std::string::npos;
    const KeyWithMark part =
        SplitAtMark(entry, may_be_missing ? '?' : '~', word);
    const std::string key = FirstKey(part.key);
    if (part.words == "K" || part.words == "P") {
      Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
      k(0, 0) = lens.Value("fx");
      k(1, 1) = lens.Value("fy");
      k(0, 2) = lens.Value("cx");
      k(1, 2) = lens.Value("cy");
      SetValueAtPath(
          key,
          MakeMatrixJson(format, part.words == "K"
                                     ? Eigen::MatrixXd(k)
                                     : MakeProjectionMatrix(camera, k)),
          map);
      continue;
    }
    std::vector<double> numbers;
    for (const std::string& parameter : SplitText(part.words, ','))
      numbers.push_back(GetValueInFile(format, lens, parameter));
    if (numbers.size() == 1) {
      SetValueAtPath(key, numbers[0], map);
      continue;
    }
    if (part.has_mark && format.syntax != KeyedSyntax::kLines)
      TrimTrailingValues(format.syntax == KeyedSyntax::kNumbers, &numbers);
    SetValueAtPath(key, numbers, map);
  }
}

void AddPose(const KeyedFormat& format, const std::optional<Pose>& given,
             const std::string& word, Json* map) {
  if (format.poses.empty() || !format.poses.front().word.empty()) return;
  const KeyedPose& row = format.poses.front();
  const Pose pose = given.value_or(Pose{});
  const std::vector<std::string> keys = SplitText(row.keys);
  if (row.kind == PoseKind::kVectors || row.kind == PoseKind::kRAndT) {
    const Eigen::AngleAxisd turn(pose.rotation);
    const Eigen::Vector3d vector = turn.angle() * turn.axis();
    const Eigen::Matrix3d matrix = pose.rotation.toRotationMatrix();
    SetValueAtPath(SubstituteCameraName(keys[0], word),
                   MakeFlatMatrix(row.kind == PoseKind::kVectors
                                      ? Eigen::MatrixXd(vector.transpose())
                                      : Eigen::MatrixXd(matrix)),
                   map);
    SetValueAtPath(SubstituteCameraName(keys[1], word),
                   MakeFlatMatrix(pose.translation.transpose()), map);
    return;
  }
  const Pose written =
      row.kind == PoseKind::kCameraFromRig ? pose : pose.Inverse();
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = written.rotation.toRotationMatrix();
  matrix.topRightCorner<3, 1>() = written.translation;
  const Json numbers = MakeFlatMatrix(matrix);
  if (format.syntax == KeyedSyntax::kYaml)
    SetValueAtPath(keys[0], {{"cols", 4}, {"rows", 4}, {"data", numbers}}, map);
  else
    SetValueAtPath(keys[0], numbers, map);
}

void AddCamera(const KeyedFormat& format, const OutputCamera& camera,
               const std::string& word, Json* map) {
  const KeyedModel& model = GetKeyedModel(format, *camera.lens.external_model);
  for (const auto& [key, text] : format.written) SetValueAtPath(key, text, map);
  if (!format.fit_key.empty() && camera.fit)
    SetValueAtPath(format.fit_key,
                   fmt::format("nearest {}: {}", model.external_model.name,
                               FormatModelFit(*camera.fit)),
                   map);
  if (!format.camera_name.empty() && !camera.name.empty())
    SetValueAtPath(format.camera_name, Printable(camera.name), map);
  AddSize(format, camera.lens.size, word, map);
  AddModel(model, map);
  AddValues(format, model, camera, word, map);
  AddPose(format, camera.camera_from_rig, word, map);
}

// Builds the tree of the file with the cameras at the format's location.
Json FileTree(const KeyedFormat& format, const WriteRequest& request) {
  Json root = Json::object();
  const std::vector<std::string> places = SplitText(format.place, '|');
  const std::string place = places.empty() ? "" : places.back();
  if (!format.words.empty() &&
      request.cameras.size() >
          (format.SupportsRigs() ? format.words.size() : 1))
    throw InputError(fmt::format("{} cameras, but {} supports up to {}",
                                 request.cameras.size(), format.name,
                                 format.words.size()));
  for (size_t k = 0; k < request.cameras.size(); ++k) {
    const OutputCamera& camera = request.cameras[k];
    if (place.empty()) {
      AddCamera(format, camera, format.words.empty() ? "" : format.words[k],
                &root);
      continue;
    }
    OutputCamera named = camera;
    if (named.name.empty()) named.name = fmt::format("cam_{}", k);
    Json map = Json::object();
    AddCamera(format, named, "", &map);
    const std::string name = !format.camera_name.empty()
                                 ? fmt::format("cam_{}", k)
                                 : Printable(named.name);
    if (place == "*")
      root[name] = std::move(map);
    else
      root[place].push_back(std::move(map));
  }
  return root;
}

// ---- Texts -----------------------------------------------------------------

std::string FormatScalar(const Json& value) {
  if (value.is_number_float()) return FormatReal(value.get<double>());
  if (!value.is_string()) return value.dump();
  const std::string text = value.get<std::string>();
  return QuotedYaml(text);
}

// Strings that no YAML parser misinterprets are written without quotes.
std::string YamlScalar(const Json& value) {
  if (!value.is_string()) return FormatScalar(value);
  const std::string text = value.get<std::string>();
  const bool is_text =
      !text.empty() && std::isalpha(static_cast<unsigned char>(text[0])) &&
      std::all_of(text.begin(), text.end(), [](unsigned char c) {
        return std::isalnum(c) || c == '_' || c == '-';
      });
  return is_text && text.size() > 3 && text != "null" ? text : QuotedYaml(text);
}

// Formats a list in brackets, the common syntax of YAML and TOML.
std::string FormatList(const Json& list) {
  std::string text;
  for (const Json& value : list)
    text += (text.empty() ? "" : ", ") +
            (value.is_array() ? FormatList(value) : FormatScalar(value));
  return "[" + text + "]";
}

std::string FormatYaml(const Json& map, const std::string& indentation) {
  std::string text;
  for (const auto& [key, value] : map.items()) {
    text += indentation + key + ":";
    if (value.is_object())
      text += "\n" + FormatYaml(value, indentation + "   ");
    else if (value.is_array() && !value.empty() && value[0].is_object())
      for (const Json& entry : value) {
        std::string entries;
        for (const auto& [name, inner] : entry.items())
          entries += fmt::format(
              "{}{}: {}", entries.empty() ? "" : ",\n        ", name,
              inner.is_array() ? FormatList(inner) : YamlScalar(inner));
        text += fmt::format("\n     - {{{}}}{}", entries,
                            &entry == &value.back() ? "\n" : "");
      }
    else
      text += " " + (value.is_array() ? FormatList(value) : YamlScalar(value)) +
              "\n";
  }
  return text;
}

std::string FormatToml(const Json& tables) {
  std::string text;
  for (const auto& [name, table] : tables.items()) {
    text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", name);
    for (const auto& [key, value] : table.items())
      text += fmt::format(
          "{} = {}\n", key,
          value.is_array() ? FormatList(value) : FormatScalar(value));
  }
  return text;
}

std::string FormatLines(const Json& map) {
  std::string text;
  for (const auto& [key, value] : map.items()) {
    text += key + ":";
    for (const Json& number : value) text += " " + FormatScalar(number);
    text += "\n";
  }
  return text;
}

std::string FormatNumbers(const Json& numbers) {
  std::string text;
  for (const Json& number : numbers)
    text += (text.empty() ? "" : " ") + FormatScalar(number);
  return text + "\n";
}

// Comments on the fit of approximated models, for formats that have comments
// but no key for it.
std::string FormatFitComments(const KeyedFormat& format,
                              const WriteRequest& request) {
  std::string text;
  if (!format.fit_key.empty()) return text;
  for (const OutputCamera& camera : request.cameras)
    if (camera.fit)
      text += fmt::format("# {}{}nearest {}: {}\n", Printable(camera.name),
                          camera.name.empty() ? "" : ": ",
                          camera.lens.external_model->name,
                          FormatModelFit(*camera.fit));
  return text;
}

}  // namespace

std::string WriteKeyed(const KeyedFormat& format, const WriteRequest& request) {
  const Json tree = FileTree(format, request);
  switch (format.syntax) {
    case KeyedSyntax::kJson:
      return tree.dump(2) + "\n";
    case KeyedSyntax::kToml:
      return FormatFitComments(format, request) + FormatToml(tree);
    case KeyedSyntax::kLines:
      return FormatLines(tree);
    case KeyedSyntax::kNumbers:
      return FormatFitComments(format, request) +
             FormatNumbers(tree["numbers"]);
    case KeyedSyntax::kStorage:
      return "%YAML:1.0\n---\n" + FormatFitComments(format, request) +
             FormatYaml(tree, "");
    default:
      return FormatFitComments(format, request) + FormatYaml(tree, "");
  }
}

}  // namespace raygrid
