#ifndef RAYGRID_EXCHANGE_ROS_FORMAT_H
#define RAYGRID_EXCHANGE_ROS_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// The camera_info of ROS, as camera_calibration_parsers has it in YAML; read,
/// too, as 'rostopic echo' and 'ros2 topic echo' print it.
Format RosFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_ROS_FORMAT_H
