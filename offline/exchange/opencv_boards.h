/// Corners and board poses in files of OpenCV's calibration sample.
#ifndef RAYGRID_EXCHANGE_OPENCV_BOARDS_H
#define RAYGRID_EXCHANGE_OPENCV_BOARDS_H

#include <yaml-cpp/yaml.h>

#include <vector>

#include "exchange/file_storage.h"
#include "exchange/format.h"

namespace raygrid {
namespace opencv_file {

constexpr char kPointsKey[] = "image_points";

/// Reads the features of a camera, or sets the reason why there are none. An
/// undefined board is not an error, since the camera is valid without it.
void ReadBoardFeatures(const YAML::Node& root, const ReadRequest& request,
                       InputCamera* camera);

/// Reads the corners of a file without a camera. Throws InputError.
ExchangeContents ReadCornersOnly(const YAML::Node& root,
                                 const ReadRequest& request);

/// Reads extrinsic_parameters: a rotation vector and a translation per row.
/// Throws InputError.
std::vector<BoardPose> ReadBoardPoses(const YAML::Node& root);

/// Writes board poses, with the names of their images and boards.
void AddPoses(const std::vector<BoardPose>& poses, FileStorageText* text);

}  // namespace opencv_file
}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_OPENCV_BOARDS_H
