/// Bags wherever images are accepted: BAG, or BAG:TOPIC.
#ifndef RAYGRID_TOOLS_BAG_INPUT_H
#define RAYGRID_TOOLS_BAG_INPUT_H

#include <CLI/CLI.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bags/image_topics.h"
#include "camera_values.h"
#include "dataset/image_times.h"

namespace raygrid {

struct BagOptions {
  std::string topic;
  ImageSelection selection;
  double tolerance_s = 0.005;
};

/// Adds --topic, --every, --from-s, --to-s and --stamps in a group of their
/// own; for commands that accept rigs also --sync-tolerance-s.
void AddBagOptions(CLI::App* command, BagOptions* options, bool accepts_rigs);

/// A bag, and the topic that is selected in it; "" if none is.
struct BagArgument {
  std::string bag, topic;
};

/// Returns whether an argument is BAG or BAG:TOPIC.
std::optional<BagArgument> ParseBagArgument(const std::string& text);

/// The header of an image of a bag, by the image's path.
struct BagFrame {
  std::string topic, frame_id, encoding;
  int64_t stamp_ns = 0, log_ns = 0;
};
using BagFrames = std::map<std::string, BagFrame>;

/// Replaces bags among images and folders by the paths of their images,
/// BAG:TOPIC/STAMP, which ReadFile() reads. Remarks are printed unless quiet.
/// frames: receives the headers of the images. Throws InputError; Error(kUsage)
/// for unknown topics, and for options of bags without a bag.
std::vector<std::string> ExpandBags(const std::vector<std::string>& images,
                                    const BagOptions& options, bool quiet,
                                    BagFrames* frames = nullptr);

/// Returns the times of images by their names, since the first image: seconds
/// since 1970 would be rounded.
ImageTimes MakeImageTimes(const BagFrames& frames);

/// ExpandBags() for the cameras of a rig, NAME=BAG:TOPIC; empty if none is one.
/// Images of a frame have the same name. times: receives the times of each
/// camera's images. Throws Error(kUsage) if only some are bags, or if --sync-by
/// is not "name".
std::vector<RigCameraImages> ExpandRigBags(
    const std::vector<NamedValue>& cameras, const BagOptions& options,
    const std::string& sync_by, bool quiet,
    std::vector<ImageTimes>* times = nullptr);

/// Whether an output path is that of a bag: .mcap.
bool IsBagOutput(const std::string& path);

/// Reads the file of a camera; from BAG or BAG:TOPIC, a message of
/// sensor_msgs/CameraInfo as ROS prints it, which is one of the formats of
/// exchange. Remarks on the bag are printed.
std::string ReadCameraBytes(const std::string& path);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_BAG_INPUT_H
