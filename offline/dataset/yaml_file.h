#ifndef RAYGRID_DATASET_YAML_FILE_H
#define RAYGRID_DATASET_YAML_FILE_H

#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/node/node.h>

#include <string>

#include "dataset/error.h"

namespace raygrid {

/// Whether the last line of a file may lack its end, as programs of others
/// write it. raygrid's own files end with one, so that a cut shows.
enum class LastLine { kEnds, kMayLackEnd };

/// Throws InputError if a YAML file is no text file, is too large for what
/// raygrid keeps in such files (RequireSmallTree()), ends within a line, has
/// more behind its end, or has a key twice in one mapping, of which parsers
/// take the first or the last as they like. Says nothing of text that is no
/// YAML: parsing it does.
void RequireYamlFile(const std::string& path, const std::string& text,
                     LastLine last_line = LastLine::kEnds);

/// Throws InputError, without the file's name, if a file is not of a kind, such
/// as "camera" or "rig"; it says which other kind of ours it is.
void RequireKind(const YAML::Node& root, const std::string& kind);

/// Any number that a file consists of: neither NaN nor beyond arithmetic.
/// Throws InputError with the name and the line.
double YamlNumber(const YAML::Node& node, const std::string& name);

/// Throws InputError with the name if a node is no list of that size.
void RequireYamlList(const YAML::Node& node, const char* name, int size);

/// The InputError of a parser's exception: path, line if it has one, and what
/// is wrong.
InputError YamlError(const std::string& path, const YAML::Exception& error);

/// The result of read(). Errors of the parser, and InputErrors of what it
/// parsed, become InputErrors that begin with the path.
template <typename Read>
auto ReadNamingFile(const std::string& path, const Read& read) {
  try {
    return read();
  } catch (const YAML::Exception& error) {
    throw YamlError(path, error);
  } catch (const InputError& error) {
    const std::string message = error.what();
    if (message.rfind(path, 0) == 0) throw;
    throw InputError(path + ": " + message);
  }
}

}  // namespace raygrid

#endif  // RAYGRID_DATASET_YAML_FILE_H
