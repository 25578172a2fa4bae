#ifndef RAYGRID_DATASET_SPREAD_NODE_H
#define RAYGRID_DATASET_SPREAD_NODE_H

#include <yaml-cpp/yaml.h>

#include <optional>

#include "camera/lens_spread.h"

namespace raygrid {

/// spread in a camera file: columns, rows, displacements_px. Nothing of a file
/// without it. Throws InputError without the file's name.
std::optional<LensSpread> ParseSpread(const YAML::Node& node);

/// Adds this key to the map that is being written.
void EmitSpread(const LensSpread& spread, YAML::Emitter* out);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_SPREAD_NODE_H
