/// The images of a bag, and the frames of a rig.
#ifndef RAYGRID_BAGS_IMAGE_TOPICS_H
#define RAYGRID_BAGS_IMAGE_TOPICS_H

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bags/bag.h"
#include "camera/area.h"

namespace raygrid {

/// An image, without its pixels.
struct BagImage {
  int64_t stamp_ns = 0, log_ns = 0;
  ImageSize size;
  MessagePlace place;
};

/// The images of a topic in the order of the bag.
struct ImageTopic {
  BagTopic topic;
  std::string frame_id, encoding;  ///< of the first image; "" if compressed
  std::vector<BagImage> images;
  uint64_t num_undecoded = 0;
  std::string first_failure;  ///< of a message that does not decode
};

/// All images of a bag.
struct BagIndex {
  std::shared_ptr<Bag> bag;
  int64_t start_ns = 0;  ///< earliest log time of any message
  std::vector<ImageTopic> topics;

  /// Returns the topic with this name; "" means the only one. Throws
  /// Error(kUsage), listing the nearest names.
  const ImageTopic& Find(const std::string& name) const;
};

/// Reads a bag once.
BagIndex IndexBag(const std::string& path,
                  const std::function<void(double)>& progress = {});

struct ImageSelection {
  int every = 1;      ///< use one of this many images
  double from_s = 0;  ///< seconds from the start of the bag
  double to_s = INFINITY;
  bool by_log_time = false;  ///< instead of the header's stamps
};

/// Selected images in the order of their stamps, which are distinct.
struct SelectedImages {
  std::vector<BagImage> images;
  std::vector<std::string> remarks;  ///< about stamps and undecoded messages
};

/// Throws InputError if there are none, or if the image size changes.
SelectedImages SelectImages(const BagIndex& index, const ImageTopic& topic,
                            const ImageSelection& selection);

/// Returns the name of an image: its stamp, as in 1700000000.123456789. Names
/// sort like stamps.
std::string FormatStamp(int64_t stamp_ns);

/// Images of a rig's cameras, of which those with the same name are a frame.
struct PairedImages {
  std::vector<std::vector<std::string>> names;  ///< of each camera's images
  std::vector<std::string> remarks;  ///< drop-outs, and clocks that differ
};

/// Images of different cameras are a frame if their stamps are mutually nearest
/// to that of the frame's first camera, in the order of cameras, and differ
/// from it by at most the tolerance; a frame has the name of that camera's
/// image. Throws InputError if a camera has no frame in common with any other.
PairedImages PairImages(const std::vector<std::string>& cameras,
                        const std::vector<SelectedImages>& images,
                        double tolerance_s);

}  // namespace raygrid

#endif  // RAYGRID_BAGS_IMAGE_TOPICS_H
