#include "dataset/dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <tuple>
#include <unordered_map>

#include "dataset/csv.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

using FeatureKey = std::tuple<int, int, int>;

FeatureKey MakeKey(const Feature& feature) {
  return {feature.board, feature.column, feature.row};
}

// Collects features by image name, in the order of first appearance. Rows of
// one image are mostly consecutive.
class FeatureCollector {
 public:
  explicit FeatureCollector(std::map<std::string, Dataset>* datasets)
      : datasets_(datasets) {}

  void Add(const CsvReader& table, const std::string& camera,
           const std::string& image, const Feature& feature) {
    if (!image_ || camera != camera_ || image != image_->image)
      SelectImage(table, camera, image);
    std::vector<Feature>& features = image_->features;
    if (features.size() == kMaxPatternPoints)
      throw InputError(fmt::format(
          "{}: image {} has more than {} features, the limit of a pattern",
          table.Place(), Printable(image), kMaxPatternPoints));
    if (!features.empty() && MakeKey(features.back()) == MakeKey(feature))
      ThrowOnSecond(table);
    features.push_back(feature);
  }

  [[noreturn]] static void ThrowOnSecond(const CsvReader& table) {
    throw InputError(
        table.Place() +
        ": duplicate feature of this image; remove one of the lines");
  }

 private:
  void SelectImage(const CsvReader& table, const std::string& camera,
                   const std::string& image) {
    Dataset& dataset = (*datasets_)[camera];
    const auto [entry, is_new] =
        index_[camera].try_emplace(image, dataset.images.size());
    if (is_new) dataset.images.push_back({image, {}});
    if (is_new && ++num_images_ > kMaxTableImages)
      throw InputError(fmt::format(
          "{}: more than {} images; a few hundred suffice for a calibration",
          table.Place(), kMaxTableImages));
    camera_ = camera;
    image_ = &dataset.images[entry->second];
  }

  std::map<std::string, Dataset>* datasets_;
  std::map<std::string, std::unordered_map<std::string, size_t>> index_;
  size_t num_images_ = 0;
  std::string camera_;
  ImageFeatures* image_ = nullptr;
};

// Returns a feature that occurs twice in an image, if any.
std::optional<FeatureKey> FindRepeatedFeature(const ImageFeatures& image) {
  std::vector<FeatureKey> keys;
  keys.reserve(image.features.size());
  for (const Feature& feature : image.features)
    keys.push_back(MakeKey(feature));
  std::sort(keys.begin(), keys.end());
  const auto repeated = std::adjacent_find(keys.begin(), keys.end());
  if (repeated == keys.end()) return std::nullopt;
  return *repeated;
}

CsvReader FeatureTable(const std::string& path, const std::string& text) {
  return CsvReader(path, text, {"image", "board", "column", "row", "x", "y"});
}

Feature ReadFeature(const CsvReader& table) {
  return {table.Integer("board"),
          table.Integer("column"),
          table.Integer("row"),
          {table.Number("x"), table.Number("y")}};
}

std::string ReadCameraName(const CsvReader& table, bool has_camera) {
  return has_camera ? table.Text("camera") : "";
}

// Throws InputError with the line number of the duplicate feature.
void ThrowDuplicateFeature(const std::string& path, const std::string& text,
                           const std::string& camera, const std::string& image,
                           const FeatureKey& key) {
  CsvReader table = FeatureTable(path, text);
  const bool has_camera = table.HasColumn("camera");
  int count = 0;
  while (table.Next())
    if (table.Text("image") == image &&
        ReadCameraName(table, has_camera) == camera &&
        MakeKey(ReadFeature(table)) == key && ++count == 2)
      FeatureCollector::ThrowOnSecond(table);
}

// Formats one line per feature, each starting with prefix.
std::string FormatFeatureLines(const std::string& prefix,
                               const Dataset& dataset) {
  std::string text;
  for (const ImageFeatures& image : dataset.images) {
    const std::string name = CsvField(image.image);
    for (const Feature& feature : image.features)
      text += fmt::format("{}{},{},{},{},{:.5f},{:.5f}\n", prefix, name,
                          feature.board, feature.column, feature.row,
                          feature.pixel.x(), feature.pixel.y());
  }
  return text;
}

std::string PoseLines(const std::string& prefix,
                      const std::vector<BoardPose>& poses) {
  std::string text;
  for (const BoardPose& pose : poses) {
    Eigen::Quaterniond q = pose.camera_from_board.rotation;
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    const Eigen::Vector3d& t = pose.camera_from_board.translation;
    text += fmt::format(
        "{}{},{},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f}\n", prefix,
        CsvField(pose.image), pose.board, q.w(), q.x(), q.y(), q.z(), t.x(),
        t.y(), t.z());
  }
  return text;
}

// Returns the last number of a file name without extension, without its leading
// zeros.
std::string LastNumber(const std::string& file_name) {
  const std::string stem = file_name.substr(0, file_name.rfind('.'));
  const char digits[] = "0123456789";
  const size_t last = stem.find_last_of(digits);
  if (last == std::string::npos) return "";
  const size_t before = stem.find_last_not_of(digits, last);
  const size_t first = before == std::string::npos ? 0 : before + 1;
  const size_t significant = stem.find_first_not_of('0', first);
  return stem.substr(std::min(significant, last),
                     last + 1 - std::min(significant, last));
}

}  // namespace

size_t Dataset::num_features() const {
  size_t count = 0;
  for (const ImageFeatures& image : images) count += image.features.size();
  return count;
}

std::map<std::string, Dataset> ReadFeatures(const std::string& path) {
  return ParseFeatures(path, ReadFile(path));
}

std::map<std::string, Dataset> ParseFeatures(const std::string& path,
                                             const std::string& text) {
  CsvReader table = FeatureTable(path, text);
  const bool has_camera = table.HasColumn("camera");
  std::map<std::string, Dataset> datasets;
  {
    FeatureCollector collector(&datasets);
    while (table.Next())
      collector.Add(table, ReadCameraName(table, has_camera),
                    table.Text("image"), ReadFeature(table));
  }
  for (const auto& [camera, dataset] : datasets)
    for (const ImageFeatures& image : dataset.images)
      if (const auto repeated = FindRepeatedFeature(image))
        ThrowDuplicateFeature(path, text, camera, image.image, *repeated);
  if (datasets.empty())
    throw InputError(path + ": contains no features; run raygrid detect first");
  return datasets;
}

std::string FormatFeatures(const Dataset& dataset) {
  return "image,board,column,row,x,y\n" + FormatFeatureLines("", dataset);
}

std::string FormatFeatures(const std::vector<NamedDataset>& cameras) {
  std::string text = "camera,image,board,column,row,x,y\n";
  for (const NamedDataset& camera : cameras)
    text += FormatFeatureLines(CsvField(camera.camera) + ",", camera.dataset);
  return text;
}

void RenameImagesByNumber(const std::string& source, Dataset* dataset) {
  std::map<std::string, std::string> names;  // image names by number
  for (ImageFeatures& image : dataset->images) {
    const std::string number = LastNumber(image.image);
    if (number.empty())
      throw InputError(fmt::format("{}, image {}: no frame number in its name",
                                   source, image.image));
    const auto [entry, is_new] = names.emplace(number, image.image);
    if (!is_new)
      throw InputError(fmt::format(
          "{}: images {} and {} have the same frame number {}; rename one",
          source, entry->second, image.image, number));
    image.image = number;
  }
}

void RequireConsistent(const std::string& name, const Dataset& dataset,
                       const Pattern& pattern) {
  const Area image = {-0.5, -0.5, dataset.image_size.width - 0.5,
                      dataset.image_size.height - 0.5};
  for (const ImageFeatures& features : dataset.images) {
    for (const Feature& feature : features.features) {
      const std::string place =
          fmt::format("{}, image {}, feature ({}, {})", name, features.image,
                      feature.column, feature.row);
      const Board* board = pattern.FindBoard(feature.board);
      if (!board)
        throw InputError(
            fmt::format("{}: board {} is not in the pattern; use the pattern "
                        "that the features were detected with",
                        place, feature.board));
      if (feature.column < 0 || feature.column >= board->columns ||
          feature.row < 0 || feature.row >= board->rows)
        throw InputError(
            fmt::format("{}: the board has only {} x {} features; use the "
                        "pattern that the features were detected with",
                        place, board->columns, board->rows));
      if (!image.Contains(feature.pixel))
        throw InputError(fmt::format(
            "{}: ({}, {}) is outside the {} x {} image; check --image-size",
            place, feature.pixel.x(), feature.pixel.y(),
            dataset.image_size.width, dataset.image_size.height));
    }
  }
}

std::string FormatPoses(const std::vector<BoardPose>& poses) {
  return "image,board,qw,qx,qy,qz,tx,ty,tz\n" + PoseLines("", poses);
}

std::string FormatPoses(const std::vector<NamedPoses>& cameras) {
  std::string text = "camera,image,board,qw,qx,qy,qz,tx,ty,tz\n";
  for (const NamedPoses& camera : cameras)
    text += PoseLines(CsvField(camera.camera) + ",", camera.poses);
  return text;
}

std::map<std::string, std::vector<BoardPose>> ReadPoses(
    const std::string& path) {
  const std::string text = ReadFile(path);
  CsvReader table(path, text,
                  {"image", "board", "qw", "qx", "qy", "qz", "tx", "ty", "tz"});
  table.LimitRows(kMaxPoses);
  const bool has_camera = table.HasColumn("camera");
  std::map<std::string, std::vector<BoardPose>> poses;
  while (table.Next()) {
    const auto number = [&](const char* column) {
      return table.Number(column);
    };
    const Eigen::Quaterniond rotation(number("qw"), number("qx"), number("qy"),
                                      number("qz"));
    if (!(rotation.norm() > 0.5))
      throw InputError(table.Place() +
                       ": qw, qx, qy, qz are not a unit quaternion");
    poses[ReadCameraName(table, has_camera)].push_back(
        {table.Text("image"),
         table.Integer("board"),
         {rotation.normalized(), {number("tx"), number("ty"), number("tz")}}});
  }
  return poses;
}

}  // namespace raygrid
