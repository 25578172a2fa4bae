#ifndef RAYGRID_DATASET_UNCERTAINTY_NODE_H
#define RAYGRID_DATASET_UNCERTAINTY_NODE_H

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "camera/camera_uncertainty.h"

namespace raygrid {

/// The number of columns and rows of a lattice.
struct LatticeSize {
  int columns = 0, rows = 0;
};

/// Reads columns and rows, each within [least, most], from a YAML node. Throws
/// InputError that begins with name.
LatticeSize ParseLatticeSize(const YAML::Node& node, const std::string& name,
                             int least, int most);

/// Reads a lattice of standard deviations: columns, rows, stddev_px. Throws
/// exceptions of yaml-cpp, and InputError without the file's name.
UncertaintyLattice ParseUncertaintyLattice(const YAML::Node& node);

/// Writes these keys to the current mapping.
void EmitUncertaintyLattice(const UncertaintyLattice& lattice,
                            YAML::Emitter* out);

/// Reads displacements_px: lists of dx, dy with num_places entries each. Throws
/// InputError that begins with name.
std::vector<std::vector<Eigen::Vector2d>> ParseDisplacements(
    const YAML::Node& node, const std::string& name, int num_places);

/// Writes this key to the current mapping.
void EmitDisplacements(
    const std::vector<std::vector<Eigen::Vector2d>>& displacements_px,
    YAML::Emitter* out);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_UNCERTAINTY_NODE_H
