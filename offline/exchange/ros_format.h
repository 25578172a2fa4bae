#ifndef RAYGRID_EXCHANGE_ROS_FORMAT_H
#define RAYGRID_EXCHANGE_ROS_FORMAT_H

#include <yaml-cpp/yaml.h>

#include "exchange/format.h"

namespace raygrid {

/// The camera_info of ROS, as camera_calibration_parsers has it in YAML; read,
/// too, as 'rostopic echo' and 'ros2 topic echo' print it.
Format RosFormat();

/// The camera of the keys that such a file has.
ExchangeContents ReadRosCamera(const YAML::Node& root,
                               const ReadRequest& request);

/// Matrices of a camera that is written, row by row: K, D, R and P.
struct RosMatrices {
  std::vector<double> k, d, r, p;
};
RosMatrices MakeRosMatrices(const WrittenLens& camera);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_ROS_FORMAT_H
