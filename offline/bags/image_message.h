/// Images in messages of ROS 1, ROS 2 and Foxglove.
#ifndef RAYGRID_BAGS_IMAGE_MESSAGE_H
#define RAYGRID_BAGS_IMAGE_MESSAGE_H

#include <cstdint>
#include <string>
#include <string_view>

#include "bags/bag.h"
#include "camera/area.h"

namespace raygrid {

/// An image in a message, before it is decoded.
struct ImageMessage {
  int64_t stamp_ns =
      0;  ///< of the header: when the image was taken; 0: unknown
  std::string frame_id;
  ImageSize size;
  std::string encoding;  ///< "mono8", "bayer_rggb8", ...; "" if compressed
  bool is_big_endian = false;
  uint64_t step = 0;      ///< bytes per row
  std::string_view data;  ///< pixels, or an image file; in the message or below
  std::string own_data;   ///< data that were not in the message as they are

  bool IsCompressed() const { return encoding.empty(); }
};

/// Whether messages of a topic are images: Image and CompressedImage of
/// sensor_msgs, RawImage and CompressedImage of Foxglove.
bool HasImages(const BagTopic& topic);

/// Parses a message. Throws InputError, without names, if it does not decode,
/// or if its encoding is not one of an image (16UC1 is assumed to be grey, but
/// depths of 32FC1 are refused).
void ParseImageMessage(const BagTopic& topic, std::string_view data,
                       ImageMessage* message);

/// Returns an image as an image file: compressed images as they are, others as
/// PNM with their depth. YUV becomes its luma, Bayer mosaics stay mosaics,
/// alpha is dropped.
std::string MakeImageFile(const ImageMessage& message);

}  // namespace raygrid

#endif  // RAYGRID_BAGS_IMAGE_MESSAGE_H
