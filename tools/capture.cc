#include "commands.h"
#include "sibling_program.h"

namespace raygrid {

// Executes a separate program, since only capture depends on camera drivers and
// an HTTP server.
void AddCapture(CLI::App* app, CommonOptions*) {
  CLI::App* command = app->add_subcommand(
      "capture", "Capture calibration images live, guided by coverage.");
  command->set_help_flag();
  command->prefix_command();
  command->callback([command] {
    const int code =
        ExecSiblingProgram("raygrid-capture", command->remaining());
    throw CLI::RuntimeError(code);
  });
}

}  // namespace raygrid
