#ifndef RAYGRID_DATASET_POPULATION_COVARIANCE_NODE_H
#define RAYGRID_DATASET_POPULATION_COVARIANCE_NODE_H

#include <yaml-cpp/yaml.h>

#include <optional>

#include "camera/population_covariance.h"

namespace raygrid {

/// Reads the `spread` of a camera file: columns, rows, displacements_px.
/// Returns nullopt if it is missing. Throws InputError without the file's name.
std::optional<PopulationCovariance> ParsePopulationCovariance(
    const YAML::Node& node);

/// Writes this key to the current mapping.
void EmitPopulationCovariance(const PopulationCovariance& spread,
                              YAML::Emitter* out);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_POPULATION_COVARIANCE_NODE_H
