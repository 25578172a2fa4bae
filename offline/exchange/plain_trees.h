/// Parses key-value texts other than YAML and JSON to YAML trees.
#ifndef RAYGRID_EXCHANGE_PLAIN_TREES_H
#define RAYGRID_EXCHANGE_PLAIN_TREES_H

#include <yaml-cpp/yaml.h>

#include <string>

namespace raygrid {

/// TOML: tables, strings, numbers, lists. Throws InputError with the line.
YAML::Node ParseToml(const std::string& text);

/// Lines "KEY: NUMBER ..." of KITTI's calib.txt: a list per key, or a string if
/// the value is a single word. With the mark '=', MATLAB's lines "KEY =
/// [NUMBER; ...]".
YAML::Node ParseKeyLines(const std::string& text, char mark = ':');

/// Blocks of words between empty lines: lists at the keys "0", "1", ...
YAML::Node ParseBlocks(const std::string& text);

/// ROS's .ini: a key per line, followed by lines with its numbers. The size is
/// in [image].
YAML::Node ParseRosIni(const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PLAIN_TREES_H
