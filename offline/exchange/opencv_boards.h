/// Corners and poses of boards, as OpenCV's calibration sample writes them.
#ifndef RAYGRID_EXCHANGE_OPENCV_BOARDS_H
#define RAYGRID_EXCHANGE_OPENCV_BOARDS_H

#include <yaml-cpp/yaml.h>

#include <vector>

#include "exchange/file_storage.h"
#include "exchange/format.h"

namespace raygrid {
namespace opencv_file {

constexpr char kPointsKey[] = "image_points";

/// The features of a camera, or why there are none: a board that the file does
/// not say is no fault of the camera.
void TakeFeatures(const YAML::Node& root, const ReadRequest& request,
                  ReadLens* camera);

/// The corners of a file that has no camera. Throws InputError.
ExchangeContents ReadCornersOnly(const YAML::Node& root,
                                 const ReadRequest& request);

/// extrinsic_parameters: a rotation vector and a translation a row. Throws
/// InputError.
std::vector<BoardPose> ReadBoardPoses(const YAML::Node& root);

/// Adds these, with the names of their images and boards.
void AddPoses(const std::vector<BoardPose>& poses, FileStorageText* text);

}  // namespace opencv_file
}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_OPENCV_BOARDS_H
