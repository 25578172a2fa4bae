#ifndef RAYGRID_TOOLS_SIBLING_PROGRAM_H
#define RAYGRID_TOOLS_SIBLING_PROGRAM_H

#include <string>
#include <vector>

namespace raygrid {

/// Becomes another program of raygrid, which is sought beside this one, where
/// it is installed, then in the PATH. Returns only if there is none: the exit
/// code, once it is said on standard error.
int ExecSiblingProgram(const std::string& program,
                       const std::vector<std::string>& arguments);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_SIBLING_PROGRAM_H
