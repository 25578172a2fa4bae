#ifndef RAYGRID_TOOLS_IMPORT_ARGUMENTS_H
#define RAYGRID_TOOLS_IMPORT_ARGUMENTS_H

#include <string>
#include <vector>

#include "view_options.h"

namespace raygrid {

/// The words of raygrid import; "" of those that were not given.
struct ImportArguments {
  std::vector<std::string> files;
  std::string output, from, model, image_size, board;
  ViewWords view;
  bool is_reverse = false;
};

/// Outputs are told apart by how their names end: rig, poses, features.
inline bool EndsWith(const std::string& text, const std::string& word) {
  return text.size() >= word.size() &&
         text.compare(text.size() - word.size(), word.size(), word) == 0;
}

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_IMPORT_ARGUMENTS_H
