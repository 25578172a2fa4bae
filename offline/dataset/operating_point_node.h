#ifndef RAYGRID_DATASET_OPERATING_POINT_NODE_H
#define RAYGRID_DATASET_OPERATING_POINT_NODE_H

#include <yaml-cpp/yaml.h>

#include <optional>

#include "dataset/camera_file.h"

namespace raygrid {

/// Reads the operating-point model of a camera.yaml: condition, range, changes
/// (control points a, b of each term, starting with the first power), or a list
/// of them, conditions; and deviations. camera: the file's camera, at the
/// mid-range. nullopt if the node is absent. Throws exceptions of yaml-cpp, and
/// InputError without the file's name.
std::optional<OperatingPointCalibration> ParseOperatingPointModel(
    const YAML::Node& node, const CameraModel& camera);

/// Writes the key "stack" to the current mapping.
void EmitOperatingPointModel(const OperatingPointCalibration& stack,
                             YAML::Emitter* out);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_OPERATING_POINT_NODE_H
