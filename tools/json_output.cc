#include "json_output.h"

#include <fmt/format.h>

namespace raygrid {

std::string FormatCommandJson(const nlohmann::ordered_json& result) {
  nlohmann::ordered_json json = {{"schema_version", kCommandsSchemaVersion}};
  json.update(result);
  // File names may be invalid UTF-8.
  return json.dump(2, ' ', false,
                   nlohmann::ordered_json::error_handler_t::replace) +
         "\n";
}

void PrintCommandJson(const nlohmann::ordered_json& result) {
  fmt::print("{}", FormatCommandJson(result));
}

}  // namespace raygrid
