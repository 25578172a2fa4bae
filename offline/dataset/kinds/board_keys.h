/// Parsing of a board's values in pattern.yaml.
#ifndef RAYGRID_DATASET_KINDS_BOARD_KEYS_H
#define RAYGRID_DATASET_KINDS_BOARD_KEYS_H

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <string>

#include "dataset/error.h"

namespace raygrid {

/// Returns a value of a board. Throws InputError with the board's position and
/// the key.
template <typename T>
T Value(const std::string& position, const YAML::Node& node, const char* key) {
  if (!node[key])
    throw InputError(fmt::format("{}: missing key '{}'", position, key));
  try {
    return node[key].as<T>();
  } catch (const YAML::Exception&) {
    throw InputError(
        fmt::format("{}: '{}' has a value of the wrong type", position, key));
  }
}

template <typename T>
T OptionalValue(const std::string& position, const YAML::Node& node,
                const char* key, T otherwise) {
  return node[key] ? Value<T>(position, node, key) : otherwise;
}

}  // namespace raygrid

#endif  // RAYGRID_DATASET_KINDS_BOARD_KEYS_H
