#ifndef RAYGRID_DATASET_POSE_NODE_H
#define RAYGRID_DATASET_POSE_NODE_H

#include <yaml-cpp/yaml.h>

#include <string>

#include "camera/pose.h"

namespace raygrid {

/// Parses a pose in a YAML file: rotation, a unit quaternion w, x, y, z, and
/// translation in metres. Throws InputError, with the given key, or exceptions
/// of yaml-cpp.
Pose ParsePose(const std::string& key, const YAML::Node& node);

/// Formats the two keys and values of a pose, each line indented.
std::string FormatPose(const Pose& pose, const std::string& indentation);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_POSE_NODE_H
