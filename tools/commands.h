/// One function per command, which declares its options and its callback:
/// arguments -> one library call -> exit code.
#ifndef RAYGRID_TOOLS_COMMANDS_H
#define RAYGRID_TOOLS_COMMANDS_H

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "requested_operating_point.h"

namespace raygrid {

/// Options common to all commands.
struct CommonOptions {
  int threads = 0;
  uint64_t seed = 0;
  bool quiet = false;
  bool json = false;
  bool yes = false;  ///< accept implausible lengths without asking
  /// Operating point: lens position and temperature.
  RequestedOperatingPoint at;
};

/// Adds a command with the common options and an example in its help.
/// description: one sentence that fits into a line of raygrid --help. Options
/// declared next are in the group Input.
CLI::App* AddCommand(CLI::App* app, const std::string& name,
                     const std::string& description, const std::string& example,
                     CommonOptions* common);

/// Returns a validator of finite numbers above 0.
CLI::Validator AboveZero();

/// Returns the meaning of each exit code, for the end of raygrid --help.
std::string ExitCodesHelp();

/// Adds --hold-out, names of images; help: description of the option.
void AddHoldOut(CLI::App* command, const std::string& help,
                std::vector<std::string>* names);

/// Adds --at, for commands that read a camera.
void AddAtOption(CLI::App* command, CommonOptions* common);

/// Adds --allow-huge-images, for commands with images or image sizes as input.
void AddHugeOption(CLI::App* command);

#define RAYGRID_COMMAND(title, Name) \
  void Add##Name(CLI::App* app, CommonOptions* common);
#include "command_list.inc"
#undef RAYGRID_COMMAND

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_COMMANDS_H
