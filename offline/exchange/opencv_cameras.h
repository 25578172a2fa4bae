#ifndef RAYGRID_EXCHANGE_OPENCV_CAMERAS_H
#define RAYGRID_EXCHANGE_OPENCV_CAMERAS_H

#include <yaml-cpp/yaml.h>

#include "exchange/format.h"

namespace raygrid {
namespace opencv_file {

/// Reads a file that contains a camera, a pair, a relative pose, corners, or
/// mappings of cameras by name. Throws InputError.
ExchangeContents ReadTree(const YAML::Node& root, const ReadRequest& request);

/// Adds cameras in nested mappings, under their names, or lists.
void ReadNamed(const YAML::Node& root, const ReadRequest& request, int depth,
               ExchangeContents* contents);

}  // namespace opencv_file
}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_OPENCV_CAMERAS_H
