#include "exchange/keyed_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/camera_keys.h"
#include "exchange/file_storage.h"
#include "exchange/keyed_table.h"
#include "exchange/keyed_writer.h"
#include "exchange/opencv_model_list.h"
#include "exchange/plain_trees.h"
#include "exchange/radial_model.h"
#include "exchange/raygrid_json.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

// Removes images and 3D points, possibly millions, from the text of a scene.
// Text that is not JSON is left to the camera parser.
std::string StripSceneData(const std::vector<std::string>& bulk,
                           const std::string& text) {
  const auto is_bulk = [&](const std::string& key) {
    return std::find(bulk.begin(), bulk.end(), key) != bulk.end();
  };
  if (std::none_of(bulk.begin(), bulk.end(), [&](const std::string& key) {
        return text.find("\"" + key + "\"") != std::string::npos;
      }))
    return text;
  const auto keeps = [&](int, Json::parse_event_t event, Json& parsed) {
    return event != Json::parse_event_t::key ||
           !is_bulk(parsed.get<std::string>());
  };
  const Json scene = Json::parse(text, keeps, false);
  return scene.is_discarded() ? text : scene.dump();
}

YAML::Node ParseKeyed(const KeyedFormat& format, const ReadRequest& request) {
  switch (format.syntax) {
    case KeyedSyntax::kToml:
      return ParseToml(request.text);
    case KeyedSyntax::kLines:
      return ParseKeyLines(request.text);
    case KeyedSyntax::kAssignments:
      return ParseKeyLines(request.text, '=');
    case KeyedSyntax::kNumbers:
      return ParseKeyLines("numbers: " + FindNumberLine(request.text));
    case KeyedSyntax::kBlocks:
      return ParseBlocks(request.text);
    default:
      return ParseFileStorage(request.path,
                              StripSceneData(format.bulk, request.text));
  }
}

// Returns the first existing key of "KEY|KEY", or the first one.
std::string FindFirstExistingKey(const CameraKeys& keys,
                                 const std::string& names) {
  const std::vector<std::string> all = SplitText(names, '|');
  for (const std::string& name : all)
    if (keys.Has(name)) return name;
  return all.empty() ? "" : all[0];
}

// Whether the file's keys identify a model; these keys are then marked as read.
bool MatchesFileKeys(const CameraKeys& keys, const KeyedModel& model,
                     const std::string& camera) {
  const std::vector<std::string> conditions = SplitText(model.model_selector);
  std::vector<std::string> read;
  for (const std::string& condition : conditions) {
    KeyWithMark said = SplitAtMark(condition, '?', camera);
    said.key = FindFirstExistingKey(keys, said.key);
    if (said.words.empty()) {
      if (!keys.Has(said.key)) return false;
      continue;
    }
    const std::string word = Lowercase(keys.Word(said.key));
    const std::vector<std::string> words = SplitText(said.words, '|');
    const bool is_absent = word.empty() || word == "null" || word == "~";
    if (is_absent ? !said.has_mark
                  : std::none_of(words.begin(), words.end(),
                                 [&](const std::string& one) {
                                   return Lowercase(one) == word;
                                 }))
      return false;
    read.push_back(said.key);
  }
  keys.Skip(read);
  return true;
}

const KeyedModel& FindKeyedModel(const KeyedFormat& format,
                                 const CameraKeys& keys,
                                 const std::string& camera) {
  std::string said, names;
  std::set<std::string> tried;
  for (const KeyedModel& model : format.models) {
    if (MatchesFileKeys(keys, model, camera)) return model;
    if (tried.insert(model.external_model.name).second)
      names += (names.empty() ? "" : ", ") + model.external_model.name;
    said.clear();
    for (const std::string& condition : SplitText(model.model_selector)) {
      const KeyWithMark part = SplitAtMark(condition, '?', camera);
      if (part.words.empty()) continue;
      const std::string key = FindFirstExistingKey(keys, part.key);
      said += fmt::format("{}{} '{}'", said.empty() ? "" : ", ", key,
                          Printable(keys.Word(key)));
    }
  }
  throw InputError(
      fmt::format("{}: unsupported model; supported are {}", said, names));
}

// Reduces a 4 x 4 matrix to 3 x 3 if its other elements are 0 and 1.
void ReduceMatrix(const std::string& key, std::vector<double>* numbers) {
  if (numbers->size() != 16) return;
  std::vector<double> k;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) {
      const double number = (*numbers)[4 * row + column];
      if (row < 3 && column < 3)
        k.push_back(number);
      else if (number != (row == column ? 1 : 0))
        throw InputError(fmt::format("{}: not a camera matrix", key));
    }
  *numbers = k;
}

// Reads one entry of KeyedModel::values into parameter values.
void ReadKeyedValue(const KeyedFormat& format, const CameraKeys& keys,
                    const std::string& entry, const std::string& word,
                    std::map<std::string, double>* values,
                    InputCamera* camera) {
  const bool may_be_missing = entry.find("?=") != std::string::npos;
  KeyWithMark part = SplitAtMark(entry, may_be_missing ? '?' : '~', word);
  part.key = FindFirstExistingKey(keys, part.key);
  if (!keys.Has(part.key)) {
    if (may_be_missing) return;
    throw InputError(fmt::format("'{}' is missing", part.key));
  }
  const YAML::Node node = keys[part.key];
  std::vector<double> numbers = node.IsNull() || keys.IsEmptyText(part.key)
                                    ? std::vector<double>{}
                                    : AllNumbers(node, part.key);
  if (part.words == "K" || part.words == "P") {
    const bool is_p = part.words == "P";
    if (!is_p) ReduceMatrix(part.key, &numbers);
    if (numbers.size() != (is_p ? 12 : 9))
      throw InputError(fmt::format("{}: not 3 x {}", part.key, is_p ? 4 : 3));
    const auto& n = numbers;
    ReadCameraMatrix(is_p ? std::vector<double>{n[0], n[1], n[2], n[4], n[5],
                                                n[6], n[8], n[9], n[10]}
                          : n,
                     part.key, &camera->lens);
    const std::vector<double>& k = camera->lens.values;
    if (is_p && k[0] > 0 && k[1] > 0)
      // P = K [I t], and K's last row is 0 0 1.
      camera->camera_from_rig = Pose{
          Eigen::Quaterniond::Identity(),
          {(n[3] - k[2] * n[11]) / k[0], (n[7] - k[3] * n[11]) / k[1], n[11]}};
    *values = {{"fx", k[0]}, {"fy", k[1]}, {"cx", k[2]}, {"cy", k[3]}};
    return;
  }
  const std::vector<std::string> parameters = SplitText(part.words, ',');
  const bool is_longer = numbers.size() > parameters.size();
  if ((numbers.size() < parameters.size() && !part.has_mark) ||
      (is_longer &&
       std::any_of(numbers.begin() + parameters.size(), numbers.end(),
                   [](double number) { return number != 0; })))
    throw InputError(
        fmt::format("{}: found {} coefficients, but {} of {} has {}", part.key,
                    numbers.size(), camera->lens.external_model->name,
                    format.name, parameters.size()));
  for (size_t k = 0; k < std::min(numbers.size(), parameters.size()); ++k) {
    if (parameters[k] == "0" && numbers[k] != 0)
      throw InputError(fmt::format("{}: number {} is {:g}, expected 0",
                                   part.key, k + 1, numbers[k]));
    (*values)[parameters[k]] = numbers[k];
  }
}

// Looks up the image size by the suffix of the camera's token: "HD=1280x720
// VGA=672x376".
ImageSize ParseNamedSize(const std::string& sizes, const std::string& word) {
  ImageSize size;
  for (const std::string& entry : SplitText(sizes)) {
    const KeyWithMark part = SplitAtMark(entry, '?', "");
    const std::string end = "_" + part.key;
    if (word.size() < end.size() ||
        word.compare(word.size() - end.size(), end.size(), end) != 0)
      continue;
    const std::vector<std::string> sides = SplitText(part.words, 'x');
    size = {std::stoi(sides.at(0)), std::stoi(sides.at(1))};
  }
  return size;
}

ImageSize ReadKeyedSize(const KeyedFormat& format, const CameraKeys& keys,
                        const std::string& word) {
  const std::string sizes = format.size;
  if (sizes.find('=') != std::string::npos) return ParseNamedSize(sizes, word);
  std::vector<std::string> names = SplitText(SubstituteCameraName(sizes, word));
  for (std::string& name : names) name = FindFirstExistingKey(keys, name);
  if (names.empty() || !keys.Has(names[0])) return {};
  if (names.size() == 1) return GetListSize(keys[names[0]], names[0]);
  return {SidePx(keys[names[0]], names[0]), SidePx(keys[names[1]], names[1])};
}

std::optional<Pose> ReadKeyedPose(const KeyedPose& pose, const CameraKeys& keys,
                                  const std::string& word) {
  std::vector<std::vector<double>> numbers;
  for (const std::string& text : SplitText(pose.keys)) {
    const std::string key = SubstituteCameraName(text, word);
    if (!keys.Has(key)) return std::nullopt;
    numbers.push_back(AllNumbers(keys[key], key));
  }
  const std::string name = SubstituteCameraName(pose.keys, word);
  const auto require = [&](bool is_right) {
    if (!is_right) throw InputError(fmt::format("{}: expected a pose", name));
  };
  if (pose.kind == PoseKind::kVectors) {
    require(numbers[0].size() == 3 && numbers[1].size() == 3 &&
            Eigen::Map<const Eigen::Vector3d>(numbers[0].data()).norm() < 1e3);
    return Pose{RotationFromVector(
                    Eigen::Map<const Eigen::Vector3d>(numbers[0].data())),
                Eigen::Map<const Eigen::Vector3d>(numbers[1].data())};
  }
  if (pose.kind == PoseKind::kBaselineMm) {
    require(numbers[0].size() == 1);
    return Pose{Eigen::Quaterniond::Identity(), {numbers[0][0] / -1000, 0, 0}};
  }
  if (pose.kind == PoseKind::kRAndT || pose.kind == PoseKind::kInverseRAndT) {
    std::vector<double> t;
    for (size_t k = 1; k < numbers.size(); ++k)
      t.insert(t.end(), numbers[k].begin(), numbers[k].end());
    require(numbers[0].size() == 9 && t.size() == 3);
    std::vector<double> rows;
    for (int row = 0; row < 3; ++row) {
      rows.insert(rows.end(), numbers[0].begin() + 3 * row,
                  numbers[0].begin() + 3 * row + 3);
      rows.push_back(t[row]);
    }
    const Pose matrix = PoseFromMatrix(rows, name);
    return pose.kind == PoseKind::kRAndT ? matrix : matrix.Inverse();
  }
  require(numbers[0].size() == 16 || numbers[0].size() == 12);
  const Pose matrix = PoseFromMatrix(numbers[0], name);
  return pose.kind == PoseKind::kCameraFromRig ? matrix : matrix.Inverse();
}

// Reads a model with a radial polynomial. Its ray grid requires the image size.
void ReadRadialModel(const std::map<std::string, double>& values,
                     const ReadRequest& request,
                     std::vector<std::string>* warnings, InputCamera* camera) {
  if (camera->lens.skew_px != 0)
    throw InputError(
        fmt::format("camera matrix: a skew of {:g} px is not supported by {}",
                    camera->lens.skew_px, camera->lens.external_model->name));
  if (camera->lens.size == ImageSize{} && request.size)
    camera->lens.size = *request.size;
  RadialModel lens;
  lens.focal_px = {values.at("fx"), values.at("fy")};
  lens.center_px = {values.at("cx"), values.at("cy")};
  const auto coefficient = [&](const char* name) {
    return values.count(name) > 0 ? values.at(name) : 0.0;
  };
  lens.coefficients = {coefficient("c"), coefficient("b"), coefficient("a"), 0};
  camera->lens = MakeRadialCamera(camera->lens.external_model->name,
                                  camera->lens.size, lens, warnings);
}

void ReadSizeFromValues(const std::map<std::string, double>& values,
                        ImageSize* size) {
  if (values.count("width") == 0 || values.count("height") == 0) return;
  const auto side = [&](const char* name) {
    return SidePx(YAML::Node(values.at(name)), name);
  };
  *size = {side("width"), side("height")};
}

// Converts lengths, e.g. in mm, to pixels.
void ConvertLengths(LengthUnit unit, const ImageSize& size,
                    std::map<std::string, double>* values) {
  if (values->count("f_mm") > 0 && values->count("sensor_width_mm") > 0) {
    const double width_mm = values->at("sensor_width_mm");
    if (!(width_mm > 0))
      throw InputError(
          fmt::format("sensor width: {:g} mm, expected > 0", width_mm));
    (*values)["f"] = values->at("f_mm") * size.width / width_mm;
  }
  if (unit == LengthUnit::kPixel) return;
  const int longer = std::max(size.width, size.height);
  const bool is_in_image_sides = unit == LengthUnit::kImageSides;
  for (const char* length : {"f", "fx", "cx"})
    if (values->count(length) > 0)
      (*values)[length] *= is_in_image_sides ? size.width : longer;
  for (const char* length : {"fy", "cy"})
    if (values->count(length) > 0)
      (*values)[length] *= is_in_image_sides ? size.height : longer;
}

InputCamera ReadKeyedCamera(const KeyedFormat& format, const CameraKeys& keys,
                            const std::string& word, const ReadRequest& request,
                            std::vector<std::string>* warnings) {
  const KeyedModel& model = FindKeyedModel(format, keys, word);
  InputCamera camera;
  camera.lens.external_model = &model.external_model;
  camera.lens.size = ReadKeyedSize(format, keys, word);
  std::map<std::string, double> values;
  for (const std::string& entry : SplitText(model.values))
    ReadKeyedValue(format, keys, entry, word, &values, &camera);
  ReadSizeFromValues(values, &camera.lens.size);
  ConvertLengths(format.unit, camera.lens.size, &values);
  if (values.count("skew") > 0) camera.lens.skew_px = values["skew"];
  camera.lens.values.clear();
  for (const std::string& parameter : model.external_model.parameters)
    camera.lens.values.push_back(values[parameter]);
  if (model.external_model.IsGrid())
    ReadRadialModel(values, request, warnings, &camera);
  for (const KeyedPose& pose : format.poses) {
    if (!pose.word.empty() && word != pose.word) continue;
    if (!camera.camera_from_rig)
      camera.camera_from_rig = ReadKeyedPose(pose, keys, word);
  }
  for (const std::string& key : SplitText(format.ones))
    if (keys.Has(key) && !keys[key].IsNull() &&
        FiniteNumber(keys[key], key) != 1)
      throw InputError(
          fmt::format("{}: {:g}; anamorphic stretch is not supported", key,
                      FiniteNumber(keys[key], key)));
  if (!format.camera_name.empty() && keys.Has(format.camera_name)) {
    camera.name = keys.Word(format.camera_name);
    keys.Skip({format.camera_name});
  }
  return camera;
}

// Reads the cameras of one mapping: one for each token whose first value
// exists, or a single one.
void ReadKeyedCameras(const KeyedFormat& format, const CameraKeys& keys,
                      const std::string& name, const ReadRequest& request,
                      ExchangeContents* contents) {
  const size_t first = contents->cameras.size();
  const std::string value = SplitText(format.models[0].values)[0];
  if (format.words.empty()) {
    contents->cameras.push_back(
        ReadKeyedCamera(format, keys, "", request, &contents->warnings));
    InputCamera& camera = contents->cameras.back();
    if (camera.name.empty()) camera.name = name;
  }
  for (const std::string& word : format.words) {
    if (!keys.Has(SplitAtMark(value, '?', word).key)) continue;
    contents->cameras.push_back(
        ReadKeyedCamera(format, keys, word, request, &contents->warnings));
    std::string own = word.substr(word[0] == '_' ? 1 : 0);
    if (!own.empty() && own.back() == '/') own.pop_back();
    contents->cameras.back().name = fmt::format(
        "{}{}", std::isdigit(static_cast<unsigned char>(word[0])) ? "cam" : "",
        own);
  }
  if (contents->cameras.size() == first) throw InputError("contains no camera");
  if (!format.words.empty() && contents->cameras.size() == first + 1)
    contents->cameras.back().name = name;
  // If only the second camera has a pose, it is relative to the first.
  InputCamera& leader = contents->cameras[first];
  if (contents->cameras.size() > first + 1 && !leader.camera_from_rig &&
      contents->cameras.back().camera_from_rig)
    leader.camera_from_rig = Pose{};
  keys.Skip(format.others);
  keys.Finish(*leader.lens.external_model, &contents->warnings);
}

// Reads the cameras of a map of named mappings, or of a list. Mappings without
// the first key of a camera are skipped.
void ReadKeyedMaps(const KeyedFormat& format, const YAML::Node& maps,
                   const ReadRequest& request, ExchangeContents* contents) {
  int number = 0;
  for (const auto& entry : maps) {
    const YAML::Node map = maps.IsMap() ? entry.second : YAML::Node(entry);
    const std::string name = maps.IsMap() && entry.first.IsScalar()
                                 ? entry.first.as<std::string>()
                                 : fmt::format("cam{}", number);
    ++number;
    if (!map.IsMap() || (maps.IsMap() && map.size() == 0)) continue;
    const CameraKeys keys(map, Printable(name));
    if (std::none_of(
            format.models.begin(), format.models.end(),
            [&](const KeyedModel& model) {
              return keys.Has(FindFirstExistingKey(
                  keys, SplitAtMark(SplitText(model.values)[0], '?', "").key));
            }))
      continue;
    try {
      ReadKeyedCameras(format, keys, name, request, contents);
    } catch (const InputError& error) {
      const std::string message = error.what();
      if (message.rfind(Printable(name) + ": ", 0) == 0) throw;
      throw InputError(fmt::format("{}: {}", Printable(name), message));
    }
  }
}

// Returns the node at KeyedFormat::place.
YAML::Node FindNode(const YAML::Node& root, const std::string& place) {
  const CameraKeys keys(root);
  const std::vector<std::string> places = SplitText(place, '|');
  for (const std::string& path : places)
    if (path != "*" && keys.Has(path)) return keys[path];
  return places.back() == "*" ? root : YAML::Node(YAML::NodeType::Undefined);
}

ExchangeContents ReadKeyed(const KeyedFormat& format,
                           const ReadRequest& request) {
  YAML::Node root = ParseKeyed(format, request);
  // OpenSfM's reconstruction.json is a list of scenes.
  if (!format.bulk.empty() && root.IsSequence() && root.size() > 0)
    root.reset(root[0]);
  if (!root.IsMap()) throw InputError("contains no camera: expected a mapping");
  const std::string place = format.place;
  ExchangeContents contents;
  // ROS 2 parameter files nest mappings.
  while (place.empty() && root.size() == 1 && root.begin()->second.IsMap())
    root.reset(YAML::Node(root.begin()->second));
  if (place.empty()) {
    ReadKeyedCameras(format, CameraKeys(root), "", request, &contents);
    return contents;
  }
  const YAML::Node maps = FindNode(root, place);
  if (!maps.IsDefined() || (!maps.IsMap() && !maps.IsSequence()))
    throw InputError(fmt::format("'{}' is missing", place));
  ReadKeyedMaps(format, maps, request, &contents);
  if (contents.cameras.size() == 1 && maps.IsSequence())
    contents.cameras.front().name.clear();
  return contents;
}

}  // namespace

std::vector<Format> MakeKeyedFormats() {
  std::vector<Format> formats;
  for (const KeyedFormat& row : ListKeyedFormats()) {
    Format format;
    format.name = row.name;
    format.holds = row.holds;
    const bool is_written = !row.ending.empty();
    for (const KeyedModel& model : row.models)
      if (!is_written || !model.is_read_only)
        format.external_models.push_back(model.external_model);
    format.recognizes = [&row](const std::string& text) {
      return row.Recognizes(text);
    };
    format.read = [&row](const ReadRequest& request) {
      return ReadKeyed(row, request);
    };
    if (is_written) {
      format.ending = row.ending;
      format.requires_image_size = row.size.empty();
      format.supports_rigs = row.SupportsRigs();
      format.discards_rig_poses =
          !row.HasProjections() &&
          (row.poses.empty() || !row.poses.front().word.empty());
      format.write = [&row](const WriteRequest& request) {
        return WriteKeyed(row, request);
      };
    }
    formats.push_back(std::move(format));
  }
  return formats;
}

}  // namespace raygrid
