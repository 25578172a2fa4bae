#include "renamed_options.h"

#include <array>

namespace raygrid {
namespace {

struct RenamedOption {
  const char* command;  // nullptr: every command
  const char* former;
  const char* current;
};

constexpr std::array kRenamedOptions = {
    RenamedOption{nullptr, "--huge", "--allow-huge-images"},
    RenamedOption{nullptr, "--cell-px", "--knot-spacing-px"},
    RenamedOption{nullptr, "--boards-move", "--independent-boards"},
    RenamedOption{"calibrate", "--same-view-px", "--duplicate-px"},
    RenamedOption{"calibrate", "--flat-board", "--fix-target-geometry"},
    RenamedOption{"calibrate", "--rigid-board", "--rigid-target"},
    RenamedOption{"calibrate", "--measure-once", "--no-refine-features"},
    RenamedOption{"calibrate", "--like", "--prior"},
    RenamedOption{"calibrate", "--instant-by", "--sync-by"},
    RenamedOption{"calibrate", "--condition", "--vary-with"},
    RenamedOption{"calibrate", "--conditions", "--operating-points"},
    RenamedOption{"calibrate", "--camera-at", "--images-at"},
    RenamedOption{"calibrate", "--times", "--timestamps"},
    RenamedOption{"pack", "--capture", "--capture-settings"},
    RenamedOption{"pack", "--wide-grid", "--grid-32bit"},
    RenamedOption{"undistort", "--like", "--view"},
    RenamedOption{"export", "--like", "--view"},
    RenamedOption{"import", "--like", "--view"},
    RenamedOption{"undistort", "--reverse", "--inverse"},
    RenamedOption{"export", "--reverse", "--inverse"},
    RenamedOption{"import", "--reverse", "--inverse"},
    RenamedOption{"export", "--max-fit-error", "--max-fit-error-px"},
    RenamedOption{"export", "--every", "--stride"},
    RenamedOption{"import", "--board", "--board-size"},
    RenamedOption{"update", "--new", "--initialize"},
    RenamedOption{"simulate", "--shots", "--repeats"},
    RenamedOption{"simulate", "--shared-noise-px", "--correlated-noise-px"},
    RenamedOption{"simulate", "--shared-noise-features",
                  "--correlation-length"},
    RenamedOption{"simulate", "--board-bend-mm", "--target-deformation-mm"},
    RenamedOption{"simulate", "--board-flex-mm", "--per-view-deformation-mm"},
    RenamedOption{"simulate", "--row-time-us", "--line-delay-us"},
    RenamedOption{"simulate", "--never-shared", "--no-common-boards"},
    RenamedOption{"experiment", "--walk", "--colmap-model"},
    RenamedOption{"experiment", "--walks", "--trajectories"},
    RenamedOption{"experiment", "--fine", "--fine-distortion"},
    RenamedOption{"experiment", "--nearest-m", "--min-depth-m"},
};

}  // namespace

std::vector<std::string> CurrentOptionNames(
    std::vector<std::string> arguments) {
  for (size_t k = 1; k < arguments.size() && arguments[k] != "--"; ++k) {
    const std::string name = arguments[k].substr(0, arguments[k].find('='));
    for (const RenamedOption& option : kRenamedOptions)
      if (name == option.former &&
          (!option.command || arguments[0] == option.command)) {
        arguments[k].replace(0, name.size(), option.current);
        break;
      }
  }
  return arguments;
}

}  // namespace raygrid
