/// Times, lens positions and temperatures of the images that calibrate is
/// given.
#ifndef RAYGRID_TOOLS_CAPTURE_CONDITIONS_H
#define RAYGRID_TOOLS_CAPTURE_CONDITIONS_H

#include <optional>
#include <vector>

#include "calibration/operating_point_calibration.h"
#include "calibration_input.h"

namespace raygrid {

/// How images were taken.
struct CaptureConditions {
  /// Each camera's, if the time of a row is to be estimated.
  std::vector<std::optional<ImageTimes>> times;
  /// Lens positions or temperatures, if a camera is calibrated over them.
  std::optional<ImageOperatingPoints> conditions;
};

/// Reads what tells them, once: it may come through a pipe. Throws
/// Error(kUsage), InputError.
CaptureConditions ReadCaptureConditions(
    const CalibrateArguments& arguments,
    const std::vector<Measurements>& cameras);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CAPTURE_CONDITIONS_H
