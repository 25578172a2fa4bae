#ifndef RAYGRID_DATASET_YAML_FILE_H
#define RAYGRID_DATASET_YAML_FILE_H

#include <string>

namespace raygrid {

/// Throws InputError if a YAML file is no text file, ends within a line, has
/// more behind its end, or has a key twice in one mapping, of which parsers
/// take the first or the last as they like. Says nothing of text that is no
/// YAML: parsing it does.
void RequireYamlFile(const std::string& path, const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_YAML_FILE_H
