#ifndef RAYGRID_DATASET_JSON_ERROR_H
#define RAYGRID_DATASET_JSON_ERROR_H

#include <nlohmann/json.hpp>
#include <string>

namespace raygrid {

/// Describes a JSON error, "type must be number, but is array", without the
/// name of the library's exception.
inline std::string JsonProblem(const nlohmann::json::exception& error) {
  const std::string text = error.what();
  const size_t name_end = text.find("] ");
  return name_end == std::string::npos ? text : text.substr(name_end + 2);
}

}  // namespace raygrid

#endif  // RAYGRID_DATASET_JSON_ERROR_H
