#ifndef RAYGRID_DATASET_DEVIATION_NODE_H
#define RAYGRID_DATASET_DEVIATION_NODE_H

#include <yaml-cpp/yaml.h>

#include "camera/camera_uncertainty.h"

namespace raygrid {

/// A lattice of standard deviations in a YAML file: columns, rows,
/// deviation_px. Throws what yaml-cpp throws, and InputError without the file's
/// name.
DeviationLattice ParseDeviations(const YAML::Node& node);

/// Adds these keys to the map that is being written.
void EmitDeviations(const DeviationLattice& lattice, YAML::Emitter* out);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_DEVIATION_NODE_H
