#include "dataset/spread_node.h"

#include <algorithm>

#include "dataset/deviation_node.h"
#include "dataset/error.h"

namespace raygrid {

std::optional<LensSpread> ParseSpread(const YAML::Node& node) {
  if (!node) return std::nullopt;
  constexpr int kLeast = 4, kMost = 65;
  constexpr size_t kMostDisplacements = 64;
  LensSpread spread;
  spread.columns = node["columns"].as<int>();
  spread.rows = node["rows"].as<int>();
  if (std::min(spread.columns, spread.rows) < kLeast ||
      std::max(spread.columns, spread.rows) > kMost)
    throw InputError("spread: columns and rows must be 4 to 65");
  const YAML::Node fields = node["displacements_px"];
  if (!fields.IsSequence() || fields.size() == 0 ||
      fields.size() > kMostDisplacements)
    throw InputError("spread: displacements_px are not 1 to 64 lists");
  spread.displacements_px =
      ParseDisplacements(fields, "spread", spread.columns * spread.rows);
  return spread;
}

void EmitSpread(const LensSpread& spread, YAML::Emitter* out) {
  *out << YAML::Key << "spread" << YAML::Value << YAML::BeginMap << YAML::Key
       << "columns" << YAML::Value << spread.columns << YAML::Key << "rows"
       << YAML::Value << spread.rows;
  EmitDisplacements(spread.displacements_px, out);
  *out << YAML::EndMap;
}

}  // namespace raygrid
