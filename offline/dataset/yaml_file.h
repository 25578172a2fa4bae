#ifndef RAYGRID_DATASET_YAML_FILE_H
#define RAYGRID_DATASET_YAML_FILE_H

#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/node/node.h>

#include <string>

#include "dataset/error.h"

namespace raygrid {

/// Whether the last line may lack a line end, as in other programs' files.
/// raygrid's own files have one, so that truncation is detected.
enum class LastLine { kIsTerminated, kMayBeUnterminated };

/// Throws InputError if a YAML file is not text, exceeds the limits
/// (RequireSmallTree()), ends within a line, has content after its end, or
/// repeats a key in one mapping, which parsers handle differently. Syntax
/// errors are left to the parser.
void RequireYamlFile(const std::string& path, const std::string& text,
                     LastLine last_line = LastLine::kIsTerminated);

/// Throws InputError, without the file's name, if a file is not of the given
/// kind, such as "camera" or "rig"; names the actual kind if it is one of
/// raygrid's.
void RequireKind(const YAML::Node& root, const std::string& kind);

/// Parses a finite number within the supported range. Throws InputError with
/// the name and the line.
double YamlNumber(const YAML::Node& node, const std::string& name);

/// Throws InputError with the name if a node is not a list of that size.
void RequireYamlList(const YAML::Node& node, const char* name, int size);

/// Converts a parser's exception to InputError: path, line if available, and
/// reason.
InputError YamlError(const std::string& path, const YAML::Exception& error);

/// Returns read(). Parser exceptions, and InputErrors about parsed values,
/// become InputErrors that begin with the path.
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
