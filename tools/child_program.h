#ifndef RAYGRID_TOOLS_CHILD_PROGRAM_H
#define RAYGRID_TOOLS_CHILD_PROGRAM_H

#include <string>
#include <vector>

namespace raygrid {

/// How a program ended.
struct ChildEnd {
  int exit_code = 0;       ///< if no signal ended it
  int signal = 0;          ///< or 0
  std::string last_error;  ///< the last line of its standard error
};

/// Runs raygrid itself, which sees no terminal, until it ends. What it prints
/// is dropped. It ends with this program, however that ends. Throws
/// Error(kOutput) if no program can be started.
ChildEnd RunChild(const std::vector<std::string>& arguments);

/// How another program ended, and the lines that it printed.
struct ProgramEnd {
  bool is_found = true;  ///< false: no such program in the PATH
  int exit_code = 0;     ///< 128 and the signal's number if one ended it
  std::vector<std::string> lines;  ///< of standard output and error
};

/// Runs a program of the PATH until it ends; it sees no terminal. Throws
/// Error(kOutput) if no program can be started.
ProgramEnd RunProgram(const std::string& name,
                      const std::vector<std::string>& arguments);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CHILD_PROGRAM_H
