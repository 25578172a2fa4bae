/// Former names of options, which stay valid for one minor version.
#ifndef RAYGRID_TOOLS_RENAMED_OPTIONS_H
#define RAYGRID_TOOLS_RENAMED_OPTIONS_H

#include <string>
#include <vector>

namespace raygrid {

/// Replaces former option names in the arguments of raygrid, the command first:
/// "--flat-board" by "--fix-target-geometry", "--like=F" by "--prior=F".
/// Arguments after "--" are unchanged.
std::vector<std::string> CurrentOptionNames(std::vector<std::string> arguments);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_RENAMED_OPTIONS_H
