/// Output of commands with --json.
#ifndef RAYGRID_TOOLS_JSON_OUTPUT_H
#define RAYGRID_TOOLS_JSON_OUTPUT_H

#include <nlohmann/json.hpp>
#include <string>

namespace raygrid {

/// "schema_version" of formats/json/commands.schema.json.
constexpr int kCommandsSchemaVersion = 2;

/// Formats a command's result, starting with the version of its schema.
std::string FormatCommandJson(const nlohmann::ordered_json& result);
/// Prints a command's result on standard output.
void PrintCommandJson(const nlohmann::ordered_json& result);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_JSON_OUTPUT_H
