/// Files of the generic model's authors but for cameras, without what their
/// numbers mean: bytes of features, texts of poses and points.
#ifndef RAYGRID_EXCHANGE_PUZZLEPAINT_FILES_H
#define RAYGRID_EXCHANGE_PUZZLEPAINT_FILES_H

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "camera/area.h"
#include "camera/pose.h"
#include "exchange/pixel_origin.h"

namespace raygrid {

/// The place of the program's pixel (0, 0), in all of its files.
constexpr PixelOrigin kPuzzlepaintOrigin = PixelOrigin::kImageCorner;

/// "intrinsics1" of a number: the name of the camera's file, without ending.
std::string PuzzlepaintCameraName(int index);

/// A feature as the program has it: its pixel in the program's terms, its
/// number in all boards together.
struct PuzzlepaintFeature {
  Eigen::Vector2f pixel;
  int32_t id = 0;
};

/// The images that all cameras took at one time, and the features of each
/// camera.
struct PuzzlepaintImageset {
  std::string name;
  std::vector<std::vector<PuzzlepaintFeature>> cameras;
};

/// A board: columns and rows of its features, by their numbers.
struct PuzzlepaintGeometry {
  float cell_m = 0;
  std::map<int32_t, Eigen::Vector2i> places;

  /// The place of a column and row on the board: 0.03F is meant for 0.03.
  Eigen::Vector3d PointAt(const Eigen::Vector2i& place) const;
};

/// dataset.bin.
struct PuzzlepaintDataset {
  std::vector<ImageSize> image_sizes;  ///< of the cameras
  std::vector<PuzzlepaintImageset> imagesets;
  std::vector<PuzzlepaintGeometry> geometries;
};

/// Whether bytes begin as dataset.bin does.
bool IsPuzzlepaintDataset(const std::string& bytes);
/// Throws InputError, also for numbers that no feature or board has, and for a
/// feature of no board.
PuzzlepaintDataset DecodePuzzlepaintDataset(const std::string& bytes);
std::string EncodePuzzlepaintDataset(const PuzzlepaintDataset& dataset);

/// Names of the images, all different: those that the file has, or 0, 1, ... if
/// one is empty or stands twice.
std::vector<std::string> GetImageNames(const PuzzlepaintDataset& dataset);

/// camera_tr_rig.yaml and rig_tr_global.yaml: poses by the number of the camera
/// or image. Images that were not used have none.
struct PuzzlepaintPoses {
  int count = 0;  ///< of cameras or images
  std::map<int, Pose> poses;
};

/// Throws InputError, or what yaml-cpp throws.
PuzzlepaintPoses ParsePuzzlepaintPoses(const std::string& path,
                                       const std::string& text);
/// names: of cameras or images, for comments.
std::string FormatPuzzlepaintPoses(const PuzzlepaintPoses& poses,
                                   const std::map<int, std::string>& names);

/// points.yaml: features' places in the world of the poses, by their numbers.
std::map<int, Eigen::Vector3d> ParsePuzzlepaintPoints(const std::string& path,
                                                      const std::string& text);
std::string FormatPuzzlepaintPoints(
    const std::map<int, Eigen::Vector3d>& points);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PUZZLEPAINT_FILES_H
