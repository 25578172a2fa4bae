#include "commands.h"
#include "sibling_program.h"

namespace raygrid {

// A program of its own, since it alone needs cameras and a page's server.
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
