/// The option --pattern of all commands: pattern.yaml, or a board's spec.
#ifndef RAYGRID_TOOLS_PATTERN_INPUT_H
#define RAYGRID_TOOLS_PATTERN_INPUT_H

#include <string>
#include <vector>

#include "commands.h"
#include "dataset/pattern.h"

namespace raygrid {

/// remark: added to the description.
CLI::Option* AddPatternOption(CLI::App* command, std::string* pattern,
                              const std::string& warning = "");

/// Throws Error(kUsage), InputError.
Pattern LoadPattern(const std::string& pattern);

/// The option --yes, of commands that question unusual lengths.
void AddYesOption(CLI::App* command, CommonOptions* common);

/// Asks back, as one who typed metres for millimetres would want: throws
/// Error(kUsage) for squares outside 1 mm to 1 m and for boards of more than
/// 5 m, unless they are meant (--yes). mm_option: what the length was given
/// with, "--square-mm"; empty if it was read from a pattern.
void RequirePlausibleLengths(const std::string& source,
                             const std::vector<Board>& boards,
                             const std::string& mm_option,
                             const CommonOptions& common);

/// LoadPattern, and asks back about its lengths.
Pattern LoadCheckedPattern(const std::string& pattern,
                           const CommonOptions& common);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_PATTERN_INPUT_H
