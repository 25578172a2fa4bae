/// Parses and formats files of the generic model's authors other than cameras,
/// without interpretation: features (binary), poses and points (text).
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

/// Location of the program's pixel (0, 0), in all of its files.
constexpr PixelOrigin kPuzzlepaintOrigin = PixelOrigin::kImageCorner;

/// Returns the camera name for an index, the file name's stem: "intrinsics1".
std::string PuzzlepaintCameraName(int index);

/// A feature in the program's conventions: its pixel, and its index over all
/// boards.
struct PuzzlepaintFeature {
  Eigen::Vector2f pixel;
  int32_t id = 0;
};

/// Simultaneous images of all cameras, with the features of each camera.
struct PuzzlepaintImageset {
  std::string name;
  std::vector<std::vector<PuzzlepaintFeature>> cameras;
};

/// A board: feature indices by column and row.
struct PuzzlepaintGeometry {
  float cell_m = 0;
  std::map<int32_t, Eigen::Vector2i> places;

  /// Returns the position of a column and row; reads the float 0.03F as 0.03.
  Eigen::Vector3d PointAt(const Eigen::Vector2i& place) const;
};

/// The contents of dataset.bin.
struct PuzzlepaintDataset {
  std::vector<ImageSize> image_sizes;  ///< sizes by camera
  std::vector<PuzzlepaintImageset> imagesets;
  std::vector<PuzzlepaintGeometry> geometries;
};

/// Returns whether bytes begin like dataset.bin.
bool IsPuzzlepaintDataset(const std::string& bytes);
/// Throws InputError, also for invalid feature and board indices, and for
/// features without a board.
PuzzlepaintDataset DecodePuzzlepaintDataset(const std::string& bytes);
std::string EncodePuzzlepaintDataset(const PuzzlepaintDataset& dataset);

/// Returns unique image names: the file's names, or 0, 1, ... if a name is
/// empty or repeated.
std::vector<std::string> GetImageNames(const PuzzlepaintDataset& dataset);

/// camera_tr_rig.yaml or rig_tr_global.yaml: poses by index of the camera or
/// image. Unused images have no pose.
struct PuzzlepaintPoses {
  int count = 0;  ///< number of cameras or images
  std::map<int, Pose> poses;
};

/// Throws InputError or exceptions of yaml-cpp.
PuzzlepaintPoses ParsePuzzlepaintPoses(const std::string& path,
                                       const std::string& text);
/// names: names of the cameras or images, written as comments.
std::string FormatPuzzlepaintPoses(const PuzzlepaintPoses& poses,
                                   const std::map<int, std::string>& names);

/// Parses points.yaml: feature positions in the poses' world frame, by index.
std::map<int, Eigen::Vector3d> ParsePuzzlepaintPoints(const std::string& path,
                                                      const std::string& text);
std::string FormatPuzzlepaintPoints(
    const std::map<int, Eigen::Vector3d>& points);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PUZZLEPAINT_FILES_H
