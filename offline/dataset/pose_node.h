#ifndef RAYGRID_DATASET_POSE_NODE_H
#define RAYGRID_DATASET_POSE_NODE_H

#include <yaml-cpp/yaml.h>

#include <string>

#include "camera/pose.h"

namespace raygrid {

/// A pose in a YAML file: rotation, a unit quaternion w, x, y, z, and
/// translation in metres. Throws InputError, naming the key that it stands
/// under, or what yaml-cpp throws.
Pose ParsePose(const std::string& key, const YAML::Node& node);

/// The two keys and values of a pose, each line behind an indentation.
std::string FormatPose(const Pose& pose, const std::string& indentation);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_POSE_NODE_H
