/// The option --pattern of all commands: pattern.yaml, or a board's spec.
#ifndef RAYGRID_TOOLS_PATTERN_INPUT_H
#define RAYGRID_TOOLS_PATTERN_INPUT_H

#include <string>
#include <vector>

#include "commands.h"
#include "dataset/pattern.h"

namespace raygrid {

/// Adds --pattern. warning: added to its description.
CLI::Option* AddPatternOption(CLI::App* command, std::string* pattern,
                              const std::string& warning = "");

/// Loads pattern.yaml or parses a spec. Throws Error(kUsage), InputError.
Pattern LoadPattern(const std::string& pattern);

/// Adds --yes, for commands that check lengths for plausibility.
void AddYesOption(CLI::App* command, CommonOptions* common);

/// Rejects implausible lengths, as by confusing metres and millimetres: throws
/// Error(kUsage) for squares outside 1 mm to 1 m and for boards larger than 5
/// m, unless confirmed (--yes). mm_option: option that specified the length,
/// such as "--square-mm"; empty if it was read from a pattern.
void RequirePlausibleLengths(const std::string& source,
                             const std::vector<Board>& boards,
                             const std::string& mm_option,
                             const CommonOptions& common);

/// Calls LoadPattern() and RequirePlausibleLengths().
Pattern LoadCheckedPattern(const std::string& pattern,
                           const CommonOptions& common);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_PATTERN_INPUT_H
