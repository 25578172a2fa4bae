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

/// An observed feature.
struct Feature {
  int board = 0;  ///< board id in the pattern
  int column = 0, row = 0;
  Eigen::Vector2d pixel;
};

struct ImageFeatures {
  std::string image;
  std::vector<Feature> features;
};

/// The features of one camera.
struct Dataset {
  ImageSize image_size;
  std::vector<ImageFeatures> images;

  size_t num_features() const;
};

/// Maximum number of images in tables of features, poses, times and values.
/// Hours of video have fewer; larger files are rejected before they exhaust the
/// memory.
constexpr size_t kMaxTableImages = 500000;

/// Reads features.csv, keyed by camera name; "" if the file has no camera
/// column. Images keep the file's order. Throws InputError for malformed files,
/// non-finite positions, repeated features, more than kMaxTableImages images,
/// and images with more features than a pattern has.
std::map<std::string, Dataset> ReadFeatures(const std::string& path);
/// Parses features.csv; path is used in errors.
std::map<std::string, Dataset> ParseFeatures(const std::string& path,
                                             const std::string& text);
std::string FormatFeatures(const Dataset& dataset);

/// The features of one camera of a rig. Images with equal names belong to one
/// frame.
struct NamedDataset {
  std::string camera;
  Dataset dataset;
};
/// Formats features.csv, with the camera name as the first column.
std::string FormatFeatures(const std::vector<NamedDataset>& cameras);

/// Renames images to the last number in their file names, without leading
/// zeros: "left01.jpg" becomes "1". Throws InputError if there is none or two
/// images have the same; source is used in errors.
void RenameImagesByNumber(const std::string& source, Dataset* dataset);

/// Throws InputError if a feature is not on the pattern or outside the image.
void RequireConsistent(const std::string& name, const Dataset& dataset,
                       const Pattern& pattern);

/// The pose of a board in an image.
struct BoardPose {
  std::string image;
  int board = 0;
  Pose camera_from_board;
};

/// Formats poses.csv.
std::string FormatPoses(const std::vector<BoardPose>& poses);

/// The poses of boards relative to one camera of a rig.
struct NamedPoses {
  std::string camera;
  std::vector<BoardPose> poses;
};
std::string FormatPoses(const std::vector<NamedPoses>& cameras);

/// Reads poses.csv, keyed by camera name; "" if the file has no camera column.
/// Throws InputError if the file is malformed or has more than kMaxPoses poses.
constexpr size_t kMaxPoses = 2 * kMaxTableImages;
std::map<std::string, std::vector<BoardPose>> ReadPoses(
    const std::string& path);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_DATASET_H
