#ifndef RAYGRID_DATASET_STACK_NODE_H
#define RAYGRID_DATASET_STACK_NODE_H

#include <yaml-cpp/yaml.h>

#include <optional>

#include "dataset/camera_file.h"

namespace raygrid {

/// The stack of a camera.yaml: condition, range, changes (each term's control
/// points a, b one after the other, from the first power on), or a list of
/// these, conditions; and deviations. camera: the file's, the one in the middle
/// of the ranges. Nothing if the node
/// is not there. Throws what yaml-cpp throws, and InputError without the file's
/// name.
std::optional<StackOfCameras> ParseStack(const YAML::Node& node,
                                         const CameraModel& camera);

/// Adds the key "stack" to the map that is being written.
void EmitStack(const StackOfCameras& stack, YAML::Emitter* out);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_STACK_NODE_H
