#ifndef RAYGRID_V4L2_V4L2_LIST_H
#define RAYGRID_V4L2_V4L2_LIST_H

#include <string>
#include <vector>

#include "v4l2_device.h"

namespace raygrid {

/// Paths of the video devices that give frames, in the order of their numbers.
std::vector<std::string> FindV4l2Devices();

/// A device as text for people: what it is, its formats, sizes and controls.
std::string DescribeV4l2Device(V4l2Device* device);

/// All devices, as text for people.
std::string DescribeV4l2Devices();

}  // namespace raygrid

#endif  // RAYGRID_V4L2_V4L2_LIST_H
