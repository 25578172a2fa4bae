#ifndef RAYGRID_TOOLS_CHILD_PROGRAM_H
#define RAYGRID_TOOLS_CHILD_PROGRAM_H

#include <string>
#include <vector>

namespace raygrid {

/// How a child process ended.
struct ChildEnd {
  int exit_code = 0;       ///< valid if signal is 0
  int signal = 0;          ///< signal that ended it, or 0
  std::string last_error;  ///< last line of its standard error
};

/// Runs raygrid without a terminal until it ends, and discards its output. The
/// child is killed if this program ends. Throws Error(kOutputFailed) if no
/// process can be started.
ChildEnd RunChild(const std::vector<std::string>& arguments);

/// Exit status and output lines of a child process.
struct ProgramEnd {
  bool is_found = true;            ///< false: not in the PATH
  int exit_code = 0;               ///< 128 + signal number if a signal ended it
  std::vector<std::string> lines;  ///< standard output and error
};

/// Runs a program from the PATH, without a terminal, until it ends. Throws
/// Error(kOutputFailed) if no process can be started.
ProgramEnd RunProgram(const std::string& name,
                      const std::vector<std::string>& arguments);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CHILD_PROGRAM_H
