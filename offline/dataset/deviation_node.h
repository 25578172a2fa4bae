#ifndef RAYGRID_DATASET_DEVIATION_NODE_H
#define RAYGRID_DATASET_DEVIATION_NODE_H

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "camera/camera_uncertainty.h"

namespace raygrid {

/// How many places a lattice has across and down.
struct LatticeSize {
  int columns = 0, rows = 0;
};

/// columns and rows of a YAML file, from least to most each. Throws InputError
/// that begins with name.
LatticeSize ParseLatticeSize(const YAML::Node& node, const std::string& name,
                             int least, int most);

/// A lattice of standard deviations in a YAML file: columns, rows,
/// deviation_px. Throws what yaml-cpp throws, and InputError without the file's
/// name.
DeviationLattice ParseDeviations(const YAML::Node& node);

/// Adds these keys to the map that is being written.
void EmitDeviations(const DeviationLattice& lattice, YAML::Emitter* out);

/// displacements_px of a YAML file: lists of dx, dy of num_places places each.
/// Throws InputError that begins with name.
std::vector<std::vector<Eigen::Vector2d>> ParseDisplacements(
    const YAML::Node& node, const std::string& name, int num_places);

/// Adds this key to the map that is being written.
void EmitDisplacements(
    const std::vector<std::vector<Eigen::Vector2d>>& displacements_px,
    YAML::Emitter* out);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_DEVIATION_NODE_H
