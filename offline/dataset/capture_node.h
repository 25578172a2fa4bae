#ifndef RAYGRID_DATASET_CAPTURE_NODE_H
#define RAYGRID_DATASET_CAPTURE_NODE_H

#include <yaml-cpp/yaml.h>

#include <optional>

#include "dataset/capture.h"

namespace raygrid {

/// Reads the value of "capture" in a camera file; nothing if it is not there.
/// Throws InputError, without the file's name, of unknown keys and of what no
/// camera with images of that size has, or what yaml-cpp throws.
std::optional<Capture> ParseCapture(const YAML::Node& node,
                                    const ImageSize& size);

/// Writes the key "capture" and its value.
void EmitCapture(const Capture& capture, YAML::Emitter* out);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_CAPTURE_NODE_H
