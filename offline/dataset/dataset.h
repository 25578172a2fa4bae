#ifndef RAYGRID_DATASET_DATASET_H
#define RAYGRID_DATASET_DATASET_H

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "camera/area.h"
#include "camera/pose.h"
#include "dataset/pattern.h"

namespace raygrid {

/// A feature point of a board, seen in an image.
struct Feature {
  int board = 0;  ///< id in the pattern
  int column = 0, row = 0;
  Eigen::Vector2d pixel;
};

struct ImageFeatures {
  std::string image;
  std::vector<Feature> features;
};

/// The features that one camera saw.
struct Dataset {
  ImageSize image_size;
  std::vector<ImageFeatures> images;

  size_t num_features() const;
};

/// Images that tables of features, poses, times and values may name. Hours of
/// video have fewer; a file of more is refused before it fills the memory.
constexpr size_t kMaxTableImages = 500000;

/// features.csv by camera name ("" where the file has no such column). Images
/// keep the file's order. Throws InputError for malformed files, non-finite
/// positions, features stated twice, more than kMaxTableImages images, and
/// images of more features than a pattern has.
std::map<std::string, Dataset> ReadFeatures(const std::string& path);
/// The features in a file's text; path is used in errors.
std::map<std::string, Dataset> ParseFeatures(const std::string& path,
                                             const std::string& text);
std::string FormatFeatures(const Dataset& dataset);

/// The features that a camera of a rig saw. Images of one name show one
/// instant.
struct NamedDataset {
  std::string camera;
  Dataset dataset;
};
/// The text of features.csv, led by a column that names the camera.
std::string FormatFeatures(const std::vector<NamedDataset>& cameras);

/// Gives images the last number in their file names for a name, without leading
/// zeros: "left01.jpg" becomes "1". Throws InputError where there is none, and
/// where two images have the same; source is used in errors.
void NameImagesByNumber(const std::string& source, Dataset* dataset);

/// Throws InputError where a feature is not on the pattern, or not in the
/// image.
void RequireConsistent(const std::string& name, const Dataset& dataset,
                       const Pattern& pattern);

/// The pose of a board in an image.
struct BoardPose {
  std::string image;
  int board = 0;
  Pose camera_from_board;
};

/// poses.csv.
std::string FormatPoses(const std::vector<BoardPose>& poses);

/// The poses of the boards that a camera of a rig saw.
struct NamedPoses {
  std::string camera;
  std::vector<BoardPose> poses;
};
std::string FormatPoses(const std::vector<NamedPoses>& cameras);

/// poses.csv by camera name ("" where the file has no such column). Throws
/// InputError, also for more than kMaxPoses.
constexpr size_t kMaxPoses = 2 * kMaxTableImages;
std::map<std::string, std::vector<BoardPose>> ReadPoses(
    const std::string& path);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_DATASET_H
