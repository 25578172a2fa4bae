#include "dataset/uncertainty_node.h"

#include <fmt/format.h>

#include <cmath>

#include "dataset/error.h"
#include "dataset/yaml_file.h"

namespace raygrid {

LatticeSize ParseLatticeSize(const YAML::Node& node, const std::string& name,
                             int least, int most) {
  const auto count = [&](const char* key) {
    int value = 0;
    if (!node.IsMap() || !node[key] ||
        !YAML::convert<int>::decode(node[key], value) || value < least ||
        value > most)
      throw InputError(fmt::format("{}: {} must be an integer from {} to {}",
                                   name, key, least, most));
    return value;
  };
  const int columns = count("columns");
  return {columns, count("rows")};
}

UncertaintyLattice ParseUncertaintyLattice(const YAML::Node& node) {
  const LatticeSize size = ParseLatticeSize(node, "uncertainty", 2, 65);
  UncertaintyLattice lattice = {size.columns, size.rows, {}};
  const YAML::Node rows = node["deviation_px"];
  RequireYamlList(rows, "uncertainty: deviation_px", lattice.rows);
  for (const YAML::Node& row : rows) {
    RequireYamlList(row, "uncertainty: a row of deviation_px", lattice.columns);
    for (const YAML::Node& value : row) {
      lattice.stddev_px.push_back(value.IsNull() ? NAN : value.as<double>());
      if (!value.IsNull() && !(lattice.stddev_px.back() >= 0))
        throw InputError(
            "uncertainty: deviation_px must be a non-negative number");
    }
  }
  return lattice;
}

void EmitUncertaintyLattice(const UncertaintyLattice& lattice,
                            YAML::Emitter* out) {
  *out << YAML::Key << "columns" << YAML::Value << lattice.columns << YAML::Key
       << "rows" << YAML::Value << lattice.rows << YAML::Key << "deviation_px"
       << YAML::Value << YAML::BeginSeq;
  for (int row = 0; row < lattice.rows; ++row) {
    *out << YAML::Flow << YAML::BeginSeq;
    for (int column = 0; column < lattice.columns; ++column) {
      const double value = lattice.stddev_px[row * lattice.columns + column];
      if (std::isfinite(value))
        *out << fmt::format("{:.6f}", value);
      else
        *out << YAML::Null;
    }
    *out << YAML::EndSeq;
  }
  *out << YAML::EndSeq;
}

std::vector<std::vector<Eigen::Vector2d>> ParseDisplacements(
    const YAML::Node& node, const std::string& name, int num_places) {
  const std::string one = name + ": one of displacements_px",
                    all = name + ": displacements_px";
  std::vector<std::vector<Eigen::Vector2d>> displacements_px;
  for (const YAML::Node& list : node) {
    RequireYamlList(list, one.c_str(), 2 * num_places);
    std::vector<Eigen::Vector2d>& field = displacements_px.emplace_back();
    for (int i = 0; i < num_places; ++i)
      field.emplace_back(YamlNumber(list[2 * i], all),
                         YamlNumber(list[2 * i + 1], all));
  }
  return displacements_px;
}

void EmitDisplacements(
    const std::vector<std::vector<Eigen::Vector2d>>& displacements_px,
    YAML::Emitter* out) {
  *out << YAML::Key << "displacements_px" << YAML::Value << YAML::BeginSeq;
  for (const auto& field : displacements_px) {
    *out << YAML::Flow << YAML::BeginSeq;
    for (const Eigen::Vector2d& displacement : field)
      *out << fmt::format("{:.5f}", displacement.x())
           << fmt::format("{:.5f}", displacement.y());
    *out << YAML::EndSeq;
  }
  *out << YAML::EndSeq;
}

}  // namespace raygrid
