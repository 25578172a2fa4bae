#ifndef RAYGRID_TOOLS_SIBLING_PROGRAM_H
#define RAYGRID_TOOLS_SIBLING_PROGRAM_H

#include <string>
#include <vector>

namespace raygrid {

/// Executes another program of raygrid, from the folder of this one, from where
/// it is installed, or from the PATH. Returns only if it is not found: prints
/// an error and returns the exit code.
int ExecSiblingProgram(const std::string& program,
                       const std::vector<std::string>& arguments);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_SIBLING_PROGRAM_H
