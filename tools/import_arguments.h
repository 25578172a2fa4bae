#ifndef RAYGRID_TOOLS_IMPORT_ARGUMENTS_H
#define RAYGRID_TOOLS_IMPORT_ARGUMENTS_H

#include <string>
#include <vector>

#include "view_options.h"

namespace raygrid {

/// Arguments of raygrid import; "" if not given.
struct ImportArguments {
  std::vector<std::string> files;
  std::string output, from, topic, model, image_size, board;
  ViewKeyValues view;
  bool is_reverse = false;
};

/// Whether a name has a suffix: outputs are distinguished by their suffixes.
inline bool EndsWith(const std::string& text, const std::string& word) {
  return text.size() >= word.size() &&
         text.compare(text.size() - word.size(), word.size(), word) == 0;
}

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_IMPORT_ARGUMENTS_H
