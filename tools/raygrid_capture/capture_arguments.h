#ifndef RAYGRID_CAPTURE_CAPTURE_ARGUMENTS_H
#define RAYGRID_CAPTURE_CAPTURE_ARGUMENTS_H

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "capture_loop.h"
#include "commands.h"
#include "page_server.h"

namespace raygrid {

struct CaptureArguments {
  CommonOptions common;
  std::vector<std::string> sources;
  std::string pattern, output;
  std::string size, format, until;
  std::vector<std::string> controls;
  CaptureLoopOptions loop;
  double pair_within_ms = 17;
  bool resume = false, no_calibrate = false, no_page = false;
  PageAddress page;
};

/// Adds all options.
void AddCaptureOptions(CLI::App* app, CaptureArguments* arguments);

/// Parses option values that are text. Throws Error(kUsage).
void FinishCaptureArguments(CaptureArguments* arguments);

/// Opens all sources; NULL if a signal arrives. Throws Error, CameraError.
std::unique_ptr<PairedFrames> OpenFrames(const CaptureArguments& arguments);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_ARGUMENTS_H
