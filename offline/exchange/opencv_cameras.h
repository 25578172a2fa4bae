#ifndef RAYGRID_EXCHANGE_OPENCV_CAMERAS_H
#define RAYGRID_EXCHANGE_OPENCV_CAMERAS_H

#include <yaml-cpp/yaml.h>

#include "exchange/format.h"

namespace raygrid {
namespace opencv_file {

/// Reads the camera, the pair, the relative pose or the corners of a file, or
/// cameras in mappings under their names. Throws InputError.
ExchangeContents ReadTree(const YAML::Node& root, const ReadRequest& request);

/// Adds cameras in nested mappings, under their names, or lists.
void ReadNamed(const YAML::Node& root, const ReadRequest& request, int depth,
               ExchangeContents* contents);

}  // namespace opencv_file
}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_OPENCV_CAMERAS_H
