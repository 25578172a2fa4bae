#include "dataset/population_covariance_node.h"

#include <string>

#include "dataset/error.h"
#include "dataset/uncertainty_node.h"

namespace raygrid {

namespace {

PopulationCovariance ParsePrincipalDisplacements(const YAML::Node& node) {
  constexpr int kLeast = 4, kMost = 65;
  constexpr size_t kMaxDisplacements = 64;
  if (!node.IsMap())
    throw InputError("spread: expected columns, rows and displacements_px");
  const LatticeSize size = ParseLatticeSize(node, "spread", kLeast, kMost);
  const YAML::Node fields = node["displacements_px"];
  if (!fields || !fields.IsSequence() || fields.size() == 0 ||
      fields.size() > kMaxDisplacements)
    throw InputError("spread: displacements_px must be 1 to 64 lists");
  return {size.columns, size.rows,
          ParseDisplacements(fields, "spread", size.columns * size.rows)};
}

}  // namespace

std::optional<PopulationCovariance> ParsePopulationCovariance(
    const YAML::Node& node) {
  if (!node) return std::nullopt;
  try {
    return ParsePrincipalDisplacements(node);
  } catch (const InputError& error) {
    throw InputError(
        std::string(error.what()) +
        "; use the file as written by raygrid batch, or remove 'spread'");
  }
}

void EmitPopulationCovariance(const PopulationCovariance& spread,
                              YAML::Emitter* out) {
  *out << YAML::Key << "spread" << YAML::Value << YAML::BeginMap << YAML::Key
       << "columns" << YAML::Value << spread.columns << YAML::Key << "rows"
       << YAML::Value << spread.rows;
  EmitDisplacements(spread.displacements_px, out);
  *out << YAML::EndMap;
}

}  // namespace raygrid
