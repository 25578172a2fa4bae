#include "dataset/dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "dataset/csv.h"
#include "dataset/error.h"
#include "dataset/files.h"

namespace raygrid {
namespace {

using FeatureKey = std::tuple<std::string, std::string, int, int, int>;

// The dataset's images by name, in the order in which they first appear.
class ImageIndex {
 public:
  ImageFeatures& Get(Dataset* dataset, const std::string& camera,
                     const std::string& image) {
    const auto [entry, is_new] =
        index_.try_emplace({camera, image}, dataset->images.size());
    if (is_new) dataset->images.push_back({image, {}});
    return dataset->images[entry->second];
  }

 private:
  std::map<std::pair<std::string, std::string>, size_t> index_;
};

// The lines of features, each led by prefix.
std::string FeatureLines(const std::string& prefix, const Dataset& dataset) {
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

// The last digits of a file's name without its extension, leading zeros apart.
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
  const CsvTable table(path, text,
                       {"image", "board", "column", "row", "x", "y"});
  const bool has_camera = table.HasColumn("camera");
  std::map<std::string, Dataset> datasets;
  ImageIndex index;
  std::set<FeatureKey> seen;
  for (size_t i = 0; i < table.num_rows(); ++i) {
    const std::string camera = has_camera ? table.Text(i, "camera") : "";
    const std::string image = table.Text(i, "image");
    const Feature feature = {table.Integer(i, "board"),
                             table.Integer(i, "column"),
                             table.Integer(i, "row"),
                             {table.Number(i, "x"), table.Number(i, "y")}};
    if (!seen.emplace(camera, image, feature.board, feature.column, feature.row)
             .second)
      throw InputError(table.Place(i) +
                       ": this feature was given before for the same image; "
                       "remove one of the lines");
    index.Get(&datasets[camera], camera, image).features.push_back(feature);
  }
  if (datasets.empty())
    throw InputError(path + ": holds no features; detect some first");
  return datasets;
}

std::string FormatFeatures(const Dataset& dataset) {
  return "image,board,column,row,x,y\n" + FeatureLines("", dataset);
}

std::string FormatFeatures(const std::vector<NamedDataset>& cameras) {
  std::string text = "camera,image,board,column,row,x,y\n";
  for (const NamedDataset& camera : cameras)
    text += FeatureLines(CsvField(camera.camera) + ",", camera.dataset);
  return text;
}

void NameImagesByNumber(const std::string& source, Dataset* dataset) {
  std::map<std::string, std::string> names;  // by number
  for (ImageFeatures& image : dataset->images) {
    const std::string number = LastNumber(image.image);
    if (number.empty())
      throw InputError(fmt::format(
          "{}, image {}: no number in its name to tell the instant by", source,
          image.image));
    const auto [entry, is_new] = names.emplace(number, image.image);
    if (!is_new)
      throw InputError(fmt::format(
          "{}: images {} and {} have the same number {}; rename one", source,
          entry->second, image.image, number));
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
        throw InputError(fmt::format(
            "{}: board {} is not in the pattern; pass the pattern that was "
            "detected with",
            place, feature.board));
      if (feature.column < 0 || feature.column >= board->columns ||
          feature.row < 0 || feature.row >= board->rows)
        throw InputError(fmt::format(
            "{}: the board has only {} x {} features; pass the pattern that "
            "was detected with",
            place, board->columns, board->rows));
      if (!image.Contains(feature.pixel))
        throw InputError(fmt::format(
            "{}: ({}, {}) lies outside the {} x {} image; check --image-size",
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
  const CsvTable table(
      path, ReadFile(path),
      {"image", "board", "qw", "qx", "qy", "qz", "tx", "ty", "tz"});
  const bool has_camera = table.HasColumn("camera");
  std::map<std::string, std::vector<BoardPose>> poses;
  for (size_t i = 0; i < table.num_rows(); ++i) {
    const auto number = [&](const char* column) {
      return table.Number(i, column);
    };
    const Eigen::Quaterniond rotation(number("qw"), number("qx"), number("qy"),
                                      number("qz"));
    if (!(rotation.norm() > 0.5))
      throw InputError(table.Place(i) + ": qw, qx, qy, qz are no rotation");
    poses[has_camera ? table.Text(i, "camera") : ""].push_back(
        {table.Text(i, "image"),
         table.Integer(i, "board"),
         {rotation.normalized(), {number("tx"), number("ty"), number("tz")}}});
  }
  return poses;
}

}  // namespace raygrid
