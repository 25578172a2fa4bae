/// The options of `simulate`.
#ifndef RAYGRID_TOOLS_SIMULATE_OPTIONS_H
#define RAYGRID_TOOLS_SIMULATE_OPTIONS_H

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "simulation/image_rendering.h"
#include "simulation/moving_observations.h"
#include "simulation/simulated_observations.h"
#include "simulation/simulated_rig.h"

namespace raygrid {

struct SimulateArguments {
  SimulationOptions simulation;
  ImagingOptions imaging;
  PoseOptions poses;
  std::string pattern, lens = "example", camera, size = "640x480", output;
  bool render = false;
  double max_tilt_deg = 50, board_bend_mm = 0, board_deformation_mm = 0;
  double image_circle_px = 0;
  std::optional<int> features_per_image;
  int bits = 8;
  int cameras = 1;
  double baseline_m = 0.1, camera_turn_deg = 0;
  bool fixed_boards = false;
  FixedBoards fixed;
  bool boards_around = false;
  double board_rotation_deg = 15, move_board_mm = 0;
  bool moving = false;
  HandMotion motion;
  double line_delay_us = 0, frames_per_second = 30;
};

/// Adds all options except --at and the output folder.
void AddSimulateOptions(CLI::App* command, SimulateArguments* arguments);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_SIMULATE_OPTIONS_H
