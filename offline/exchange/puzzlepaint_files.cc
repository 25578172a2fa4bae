#include "exchange/puzzlepaint_files.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "dataset/byte_reader.h"
#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "dataset/yaml_file.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kDatasetMagic[] = "calib_data";
constexpr int kMaxAlongBoard = 1000, kMaxBoardPoints = 100000;
constexpr int kMaxPoseCount = 1000000;

// ---- dataset.bin -----------------------------------------------------------

// Integers are big-endian, and floats little-endian.
template <typename Number>
Number ReadInteger(ByteReader* reader) {
  return reader->Get<Number>(ByteOrder::kBig);
}

// Reads the number of elements, each with a minimum size in bytes.
uint32_t GetCount(ByteReader* reader, size_t least_bytes) {
  const auto count = ReadInteger<uint32_t>(reader);
  reader->Require(count, least_bytes);
  return count;
}

ImageSize GetImageSize(ByteReader* reader) {
  constexpr uint32_t kMaxSidePx = 1000000;
  const auto width = ReadInteger<uint32_t>(reader),
             height = ReadInteger<uint32_t>(reader);
  if (width < 1 || height < 1 || width > kMaxSidePx || height > kMaxSidePx)
    throw InputError(fmt::format("invalid image size {} x {}", width, height));
  return {static_cast<int>(width), static_cast<int>(height)};
}

PuzzlepaintFeature GetFeature(ByteReader* reader, const ImageSize& size) {
  PuzzlepaintFeature feature;
  feature.pixel.x() = reader->GetFinite<float>();
  feature.pixel.y() = reader->GetFinite<float>();
  feature.id = ReadInteger<int32_t>(reader);
  if (feature.pixel.minCoeff() < 0 || feature.pixel.x() > size.width ||
      feature.pixel.y() > size.height)
    throw InputError(fmt::format(
        "feature {} at ({:g}, {:g}) is outside the {} x {} image", feature.id,
        feature.pixel.x(), feature.pixel.y(), size.width, size.height));
  return feature;
}

PuzzlepaintImageset GetImageset(ByteReader* reader,
                                const std::vector<ImageSize>& sizes) {
  constexpr size_t kFeatureBytes = 12;
  PuzzlepaintImageset imageset;
  imageset.name = reader->GetText(ReadInteger<uint32_t>(reader));
  for (const ImageSize& size : sizes) {
    std::vector<PuzzlepaintFeature>& features = imageset.cameras.emplace_back();
    for (auto count = GetCount(reader, kFeatureBytes); count > 0; --count)
      features.push_back(GetFeature(reader, size));
  }
  return imageset;
}

void AddPosition(int32_t id, int32_t column, int32_t row,
                 PuzzlepaintGeometry* geometry) {
  if (id < 0)
    throw InputError(
        fmt::format("feature {} of a board: must not be negative", id));
  if (std::min(column, row) < 0 || std::max(column, row) >= kMaxAlongBoard)
    throw InputError(
        fmt::format("feature {}: column {} and row {} must be 0 to {}", id,
                    column, row, kMaxAlongBoard - 1));
  if (!geometry->places.emplace(id, Eigen::Vector2i(column, row)).second)
    throw InputError(fmt::format("duplicate feature {} on its board", id));
}

PuzzlepaintGeometry GetGeometry(ByteReader* reader) {
  constexpr size_t kPositionBytes = 12;
  constexpr float kMinM = 1e-6F, kMaxM = 100;
  PuzzlepaintGeometry geometry;
  geometry.cell_m = reader->GetFinite<float>();
  if (!(geometry.cell_m >= kMinM && geometry.cell_m <= kMaxM))
    throw InputError(
        fmt::format("cell size {:g} m is out of range, {:g} to {:g} m",
                    geometry.cell_m, kMinM, kMaxM));
  for (auto count = GetCount(reader, kPositionBytes); count > 0; --count) {
    const auto id = ReadInteger<int32_t>(reader),
               column = ReadInteger<int32_t>(reader),
               row = ReadInteger<int32_t>(reader);
    AddPosition(id, column, row, &geometry);
  }
  return geometry;
}

// Throws if boards are too large, positions are duplicate, or a feature belongs
// to several boards.
void RequireBoards(const std::vector<PuzzlepaintGeometry>& geometries) {
  std::set<int32_t> ids;
  int num_points = 0;
  for (size_t k = 0; k < geometries.size(); ++k) {
    std::set<std::pair<int, int>> places;
    Eigen::Vector2i size = {0, 0};
    for (const auto& [id, place] : geometries[k].places) {
      if (!ids.insert(id).second)
        throw InputError(fmt::format("feature {} is on two boards", id));
      if (!places.insert({place.x(), place.y()}).second)
        throw InputError(
            fmt::format("board {}: duplicate feature at column {}, row {}", k,
                        place.x(), place.y()));
      size = size.cwiseMax(place + Eigen::Vector2i(1, 1));
    }
    if (places.empty())
      throw InputError(fmt::format("board {}: has no features", k));
    num_points += size.prod();
    if (num_points > kMaxBoardPoints)
      throw InputError(fmt::format("the boards have more than {} features",
                                   kMaxBoardPoints));
  }
}

std::string GetFeaturePosition(size_t imageset, size_t camera, int32_t id) {
  return fmt::format("imageset {}, camera {}: feature {}", imageset, camera,
                     id);
}

// Throws unless every observed feature belongs to a board and is unique.
void RequireKnownFeatures(const PuzzlepaintDataset& dataset) {
  std::set<int32_t> known;
  for (const PuzzlepaintGeometry& geometry : dataset.geometries)
    for (const auto& place : geometry.places) known.insert(place.first);
  for (size_t i = 0; i < dataset.imagesets.size(); ++i) {
    const auto& cameras = dataset.imagesets[i].cameras;
    for (size_t c = 0; c < cameras.size(); ++c) {
      std::set<int32_t> seen;
      for (const PuzzlepaintFeature& feature : cameras[c]) {
        if (known.count(feature.id) == 0)
          throw InputError(GetFeaturePosition(i, c, feature.id) +
                           " is not listed in known_geometries");
        if (!seen.insert(feature.id).second)
          throw InputError(GetFeaturePosition(i, c, feature.id) +
                           " is a duplicate");
      }
    }
  }
}

template <typename Number>
void AppendInteger(Number number, std::string* bytes) {
  Append(number, bytes, ByteOrder::kBig);
}

void AppendCount(size_t count, std::string* bytes) {
  AppendInteger(static_cast<uint32_t>(count), bytes);
}

// ---- YAML ------------------------------------------------------------------

int WholeNumber(const YAML::Node& node, const std::string& name, int most) {
  const double number = FiniteNumber(node, name);
  if (!(number >= 0 && number <= most) || number != std::floor(number))
    throw InputError(
        fmt::format("{}: expected an integer from 0 to {}", name, most));
  return static_cast<int>(number);
}

YAML::Node LoadMap(const std::string& path, const std::string& text) {
  RequireYamlFile(path, text);
  YAML::Node root = YAML::Load(text);
  if (!root.IsMap()) throw InputError("expected a mapping");
  return root;
}

void RequireList(const YAML::Node& node, const std::string& name) {
  if (!node.IsDefined() || !(node.IsSequence() || node.IsNull()))
    throw InputError(fmt::format("{}: expected a list", name));
}

Pose ReadPose(const YAML::Node& node, const std::string& name) {
  std::array<double, 7> numbers;
  const char* const keys[] = {"qw", "qx", "qy", "qz", "tx", "ty", "tz"};
  for (size_t k = 0; k < numbers.size(); ++k)
    numbers[k] =
        FiniteNumber(node[keys[k]], fmt::format("{}: {}", name, keys[k]));
  try {
    return PoseFromQuaternion(numbers);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", name, error.what()));
  }
}

}  // namespace

std::string PuzzlepaintCameraName(int index) {
  return fmt::format("intrinsics{}", index);
}

Eigen::Vector3d PuzzlepaintGeometry::PointAt(
    const Eigen::Vector2i& place) const {
  const std::string digits = fmt::format("{}", cell_m);
  double cell = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), cell);
  return {cell * place.x(), cell * place.y(), 0};
}

bool IsPuzzlepaintDataset(const std::string& bytes) {
  return bytes.rfind(kDatasetMagic, 0) == 0;
}

PuzzlepaintDataset DecodePuzzlepaintDataset(const std::string& bytes) {
  constexpr size_t kSizeBytes = 8, kCountBytes = 4;
  ByteReader reader(bytes);
  if (reader.GetText(sizeof(kDatasetMagic) - 1) != kDatasetMagic)
    throw InputError(
        fmt::format("wrong signature, expected {}", kDatasetMagic));
  if (const auto version = ReadInteger<uint32_t>(&reader); version != 0)
    throw InputError(
        fmt::format("unsupported version {}, expected 0", version));
  PuzzlepaintDataset dataset;
  for (auto count = GetCount(&reader, kSizeBytes); count > 0; --count)
    dataset.image_sizes.push_back(GetImageSize(&reader));
  if (dataset.image_sizes.empty()) throw InputError("contains no camera");
  for (auto count = GetCount(&reader, kCountBytes); count > 0; --count)
    dataset.imagesets.push_back(GetImageset(&reader, dataset.image_sizes));
  for (auto count = GetCount(&reader, kCountBytes); count > 0; --count)
    dataset.geometries.push_back(GetGeometry(&reader));
  reader.RequireEnd();
  RequireBoards(dataset.geometries);
  RequireKnownFeatures(dataset);
  return dataset;
}

std::string EncodePuzzlepaintDataset(const PuzzlepaintDataset& dataset) {
  std::string bytes = kDatasetMagic;
  AppendCount(0, &bytes);  // version
  AppendCount(dataset.image_sizes.size(), &bytes);
  for (const ImageSize& size : dataset.image_sizes) {
    AppendCount(size.width, &bytes);
    AppendCount(size.height, &bytes);
  }
  AppendCount(dataset.imagesets.size(), &bytes);
  for (const PuzzlepaintImageset& imageset : dataset.imagesets) {
    AppendCount(imageset.name.size(), &bytes);
    bytes += imageset.name;
    for (const auto& features : imageset.cameras) {
      AppendCount(features.size(), &bytes);
      for (const PuzzlepaintFeature& feature : features) {
        Append(feature.pixel.x(), &bytes);
        Append(feature.pixel.y(), &bytes);
        AppendInteger(feature.id, &bytes);
      }
    }
  }
  AppendCount(dataset.geometries.size(), &bytes);
  for (const PuzzlepaintGeometry& geometry : dataset.geometries) {
    Append(geometry.cell_m, &bytes);
    AppendCount(geometry.places.size(), &bytes);
    for (const auto& [id, place] : geometry.places)
      for (const int32_t number : {id, place.x(), place.y()})
        AppendInteger(number, &bytes);
  }
  return bytes;
}

std::vector<std::string> GetImageNames(const PuzzlepaintDataset& dataset) {
  std::vector<std::string> names;
  std::set<std::string> distinct = {""};
  for (const PuzzlepaintImageset& imageset : dataset.imagesets) {
    RequireStorableName("image", imageset.name);
    names.push_back(imageset.name);
    distinct.insert(imageset.name);
  }
  if (distinct.size() == names.size() + 1) return names;
  for (size_t k = 0; k < names.size(); ++k) names[k] = std::to_string(k);
  return names;
}

PuzzlepaintPoses ParsePuzzlepaintPoses(const std::string& path,
                                       const std::string& text) {
  const YAML::Node root = LoadMap(path, text);
  PuzzlepaintPoses poses;
  poses.count = WholeNumber(root["pose_count"], "pose_count", kMaxPoseCount);
  RequireList(root["poses"], "poses");
  int k = 0;
  for (const YAML::Node& node : root["poses"]) {
    const std::string name = fmt::format("poses[{}]", k++);
    if (!node.IsMap()) throw InputError(name + ": expected a mapping");
    const int index =
        WholeNumber(node["index"], name + ": index", kMaxPoseCount);
    if (index >= poses.count)
      throw InputError(fmt::format("{}: index {} exceeds pose_count {}", name,
                                   index, poses.count));
    if (!poses.poses.emplace(index, ReadPose(node, name)).second)
      throw InputError(fmt::format("{}: index {} is a duplicate", name, index));
  }
  return poses;
}

std::string FormatPuzzlepaintPoses(const PuzzlepaintPoses& poses,
                                   const std::map<int, std::string>& names) {
  std::string text = fmt::format("pose_count: {}\nposes:{}\n", poses.count,
                                 poses.poses.empty() ? " []" : "");
  for (const auto& [index, pose] : poses.poses) {
    const auto name = names.find(index);
    text += fmt::format(
        "  - index: {}{}\n", index,
        name == names.end() ? "" : "  # " + Printable(name->second));
    const Eigen::Vector3d& t = pose.translation;
    const Eigen::Quaterniond& q = pose.rotation;
    for (const auto& [key, number] : {std::pair("tx", t.x()),
                                      {"ty", t.y()},
                                      {"tz", t.z()},
                                      {"qx", q.x()},
                                      {"qy", q.y()},
                                      {"qz", q.z()},
                                      {"qw", q.w()}})
      text += fmt::format("    {}: {}\n", key, FormatReal(number + 0.0));
  }
  return text;
}

std::map<int, Eigen::Vector3d> ParsePuzzlepaintPoints(const std::string& path,
                                                      const std::string& text) {
  const YAML::Node root = LoadMap(path, text);
  const std::vector<double> numbers = FiniteNumbers(root["points"], "points");
  if (numbers.size() % 3 != 0)
    throw InputError("points: expected three coordinates per point");
  const YAML::Node list = root["feature_id_to_point_index"];
  RequireList(list, "feature_id_to_point_index");
  constexpr int kMaxIds = 1 << 30;
  std::map<int, Eigen::Vector3d> points;
  for (const YAML::Node& item : list) {
    if (!item.IsMap())
      throw InputError("feature_id_to_point_index: expected a mapping");
    const int id = WholeNumber(item["feature_id"], "feature_id", kMaxIds),
              index = WholeNumber(item["point_index"], "point_index", kMaxIds);
    if (static_cast<size_t>(index) >= numbers.size() / 3)
      throw InputError(fmt::format("point_index {}: out of range, {} points",
                                   index, numbers.size() / 3));
    points[id] = {numbers[3 * index], numbers[3 * index + 1],
                  numbers[3 * index + 2]};
  }
  return points;
}

std::string FormatPuzzlepaintPoints(
    const std::map<int, Eigen::Vector3d>& points) {
  std::string list, numbers;
  int index = 0;
  for (const auto& [id, point] : points) {
    numbers += fmt::format("{}{}", numbers.empty() ? "" : ", ",
                           RealTexts({point.x(), point.y(), point.z()}));
    list +=
        fmt::format("  - feature_id: {}\n    point_index: {}\n", id, index++);
  }
  return fmt::format("points : [{}]\nfeature_id_to_point_index:{}\n{}", numbers,
                     points.empty() ? " []" : "", list);
}

}  // namespace raygrid
