#ifndef RAYGRID_DATASET_CAPTURE_NODE_H
#define RAYGRID_DATASET_CAPTURE_NODE_H

#include <yaml-cpp/yaml.h>

#include <optional>

#include "dataset/capture.h"

namespace raygrid {

/// Reads "capture" from a camera file; nullopt if it is absent. Throws
/// InputError, without the file's name, for unknown keys and values that are
/// impossible for images of that size, or exceptions of yaml-cpp.
std::optional<Capture> ParseCapture(const YAML::Node& node,
                                    const ImageSize& size);

/// Writes the key "capture" and its value.
void EmitCapture(const Capture& capture, YAML::Emitter* out);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_CAPTURE_NODE_H
