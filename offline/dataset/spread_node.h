#ifndef RAYGRID_DATASET_SPREAD_NODE_H
#define RAYGRID_DATASET_SPREAD_NODE_H

#include <yaml-cpp/yaml.h>

#include <optional>

#include "camera/lens_spread.h"

namespace raygrid {

/// Reads spread from a camera file: columns, rows, displacements_px. nullopt if
/// it is absent. Throws InputError without the file's name.
std::optional<LensSpread> ParseSpread(const YAML::Node& node);

/// Writes this key to the current mapping.
void EmitSpread(const LensSpread& spread, YAML::Emitter* out);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_SPREAD_NODE_H
