#ifndef RAYGRID_BAGS_CAMERA_INFO_H
#define RAYGRID_BAGS_CAMERA_INFO_H

#include <cstdint>
#include <string>
#include <vector>

namespace raygrid {

/// A message of sensor_msgs/CameraInfo (docs.ros.org): matrices row by row.
struct CameraInfo {
  uint32_t width = 0, height = 0;
  std::string model;
  std::vector<double> d, k, r, p;
  uint32_t binning_x = 0, binning_y = 0;
  /// x offset, y offset, height, width; 0: the whole image
  std::vector<uint32_t> roi = {0, 0, 0, 0};
};

/// Reads the first message of a topic, also of Foxglove's CameraCalibration in
/// protobuf; "" means the only topic of these types.
/// remarks: damaged parts of the bag, and later messages that differ. Throws
/// InputError; Error(kUsage) for unknown topics.
CameraInfo ReadCameraInfo(const std::string& bag, const std::string& topic,
                          std::vector<std::string>* remarks);

/// Formats a message as ROS prints it, which is YAML.
std::string FormatCameraInfo(const CameraInfo& info);

}  // namespace raygrid

#endif  // RAYGRID_BAGS_CAMERA_INFO_H
