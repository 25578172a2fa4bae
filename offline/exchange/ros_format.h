#ifndef RAYGRID_EXCHANGE_ROS_FORMAT_H
#define RAYGRID_EXCHANGE_ROS_FORMAT_H

#include <yaml-cpp/yaml.h>

#include "exchange/format.h"

namespace raygrid {

/// ROS's camera_info as YAML of camera_calibration_parsers; also reads the
/// output of 'rostopic echo' and 'ros2 topic echo'.
Format MakeRosFormat();

/// Reads the camera from the keys of such a file.
ExchangeContents ReadRosCamera(const YAML::Node& root,
                               const ReadRequest& request);

/// Matrices of a camera to write, row by row: K, D, R and P.
struct RosMatrices {
  std::vector<double> k, d, r, p;
};
RosMatrices MakeRosMatrices(const OutputCamera& camera);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_ROS_FORMAT_H
