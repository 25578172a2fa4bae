/// Layout of --help: lines of at most 80 characters, options in groups.
#ifndef RAYGRID_TOOLS_HELP_FORMATTER_H
#define RAYGRID_TOOLS_HELP_FORMATTER_H

#include <CLI/CLI.hpp>
#include <string>

namespace raygrid {

/// Titles of option groups in --help, in the order in which they are printed.
/// tools/command_pages lists them, too.
namespace help_group {
inline constexpr char kInput[] = "Input";
inline constexpr char kBags[] = "Bags";
inline constexpr char kModel[] = "Model";
inline constexpr char kTarget[] = "Target";
inline constexpr char kView[] = "View";
inline constexpr char kOutput[] = "Output";
inline constexpr char kAdvanced[] = "Advanced";
}  // namespace help_group

/// Prints one sentence, usage, arguments, options by group (value, default,
/// description), commands by group and the footer. Options in the group "" are
/// hidden.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override;
};

/// Starts a group, to which options declared after this call belong.
void BeginGroup(CLI::App* command, const char* group);

/// Wraps text to lines of at most 80 characters, each indented by `indent`.
std::string WrapText(const std::string& text, size_t indent);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_HELP_FORMATTER_H
