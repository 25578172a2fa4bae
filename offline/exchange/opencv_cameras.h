#ifndef RAYGRID_EXCHANGE_OPENCV_CAMERAS_H
#define RAYGRID_EXCHANGE_OPENCV_CAMERAS_H

#include <yaml-cpp/yaml.h>

#include "exchange/format.h"

namespace raygrid {
namespace opencv_file {

/// The camera, the pair, the pose of a pair or the corners of a file's map, or
/// cameras in maps under their names. Throws InputError.
ExchangeContents ReadTree(const YAML::Node& root, const ReadRequest& request);

/// Adds cameras that stand in maps under their names, or in lists.
void ReadNamed(const YAML::Node& root, const ReadRequest& request, int depth,
               ExchangeContents* contents);

}  // namespace opencv_file
}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_OPENCV_CAMERAS_H
