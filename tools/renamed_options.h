/// Former names of options, which stay valid for one minor version.
#ifndef RAYGRID_TOOLS_RENAMED_OPTIONS_H
#define RAYGRID_TOOLS_RENAMED_OPTIONS_H

#include <string>
#include <vector>

namespace raygrid {

/// The arguments of raygrid, the command first, with former option names
/// replaced by the current ones: "--flat-board" by "--fix-target-geometry",
/// "--like=F" by "--prior=F". What follows "--" is left as it is.
std::vector<std::string> CurrentOptionNames(std::vector<std::string> arguments);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_RENAMED_OPTIONS_H
