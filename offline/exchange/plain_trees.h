/// Texts of keys and values that are neither YAML nor JSON, as trees of these.
#ifndef RAYGRID_EXCHANGE_PLAIN_TREES_H
#define RAYGRID_EXCHANGE_PLAIN_TREES_H

#include <yaml-cpp/yaml.h>

#include <string>

namespace raygrid {

/// TOML of tables, texts, numbers and lists. Throws InputError, with the line.
YAML::Node ParseToml(const std::string& text);

/// Lines "KEY: NUMBER ...", each a list, or the word that stands there alone:
/// calib.txt of KITTI. With the mark '=', lines "KEY = [NUMBER; ...]" of
/// MATLAB.
YAML::Node ParseKeyLines(const std::string& text, char mark = ':');

/// ROS's .ini: a key is a line, and its numbers follow in the lines below it.
/// The size is that of [image].
YAML::Node ParseRosIni(const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PLAIN_TREES_H
