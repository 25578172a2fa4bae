#ifndef RAYGRID_EXCHANGE_ROS_INI_FORMAT_H
#define RAYGRID_EXCHANGE_ROS_INI_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// The .ini of ROS's camera_calibration: plumb_bob with 5 coefficients, or
/// rational_polynomial with 8.
Format MakeRosIniFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_ROS_INI_FORMAT_H
