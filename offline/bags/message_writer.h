/// Messages of ROS 2 in CDR. All functions throw InputError for stamps out of
/// the range of ROS 2, 1970 to 2038.
#ifndef RAYGRID_BAGS_MESSAGE_WRITER_H
#define RAYGRID_BAGS_MESSAGE_WRITER_H

#include <cstdint>
#include <string>
#include <vector>

#include "bags/camera_info.h"
#include "dataset/image_files.h"

namespace raygrid {

/// The header of a message.
struct MessageHeader {
  int64_t stamp_ns = 0;
  std::string frame_id;
};

/// sensor_msgs/Image: mono8, mono16, bgr8, bgr16, bgra8 or bgra16.
std::string WriteImageMessage(const MessageHeader& header, const Image& image);

/// sensor_msgs/CameraInfo.
std::string WriteCameraInfo(const MessageHeader& header,
                            const CameraInfo& info);

/// A transform of tf2_msgs/TFMessage: maps points from the child frame to that
/// of the header. Rotation: x, y, z, w.
struct StaticTransform {
  MessageHeader header;
  std::string child_frame_id;
  std::vector<double> translation, rotation;
};
std::string WriteTransforms(const std::vector<StaticTransform>& transforms);

}  // namespace raygrid

#endif  // RAYGRID_BAGS_MESSAGE_WRITER_H
