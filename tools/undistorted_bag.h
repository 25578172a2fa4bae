#ifndef RAYGRID_TOOLS_UNDISTORTED_BAG_H
#define RAYGRID_TOOLS_UNDISTORTED_BAG_H

#include <fstream>
#include <map>
#include <string>

#include "bag_input.h"
#include "bags/camera_info.h"
#include "bags/mcap_writer.h"
#include "dataset/image_files.h"
#include "packing/view.h"

namespace raygrid {

/// A bag of undistorted images. For images of /cam0/image_raw, it has the
/// topics /cam0/image_rect and /cam0/camera_info: the pinhole camera without
/// distortion of these images. Stamps, times of recording and frames of
/// coordinates are those of the images. Throws Error(kUsage) if the view is not
/// a pinhole.
class UndistortedBag {
 public:
  /// Throws Error(kOutputFailed), as the other functions do.
  UndistortedBag(const std::string& path, const VirtualView& view);
  /// Removes the incomplete file.
  ~UndistortedBag();
  UndistortedBag(const UndistortedBag&) = delete;
  UndistortedBag& operator=(const UndistortedBag&) = delete;

  void Add(const BagFrame& frame, const Image& image);
  /// The file appears.
  void Finish();

 private:
  struct Topics {
    uint16_t image = 0, info = 0;
  };
  void RequireWritten();

  CameraInfo info_;
  std::string path_, temporary_;
  std::ofstream file_;
  McapWriter writer_;
  std::map<std::string, Topics> topics_;  // by topic of the input
};

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_UNDISTORTED_BAG_H
