#ifndef RAYGRID_V4L2_V4L2_LIST_H
#define RAYGRID_V4L2_V4L2_LIST_H

#include <string>
#include <vector>

#include "v4l2_device.h"

namespace raygrid {

/// Paths of the video capture devices, ordered by number.
std::vector<std::string> FindV4l2Devices();

/// Describes a device: its name, formats, sizes and controls.
std::string DescribeV4l2Device(V4l2Device* device);

/// Describes all devices.
std::string DescribeV4l2Devices();

}  // namespace raygrid

#endif  // RAYGRID_V4L2_V4L2_LIST_H
