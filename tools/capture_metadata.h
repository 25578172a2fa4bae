/// Times, lens positions and temperatures of the images of a calibration.
#ifndef RAYGRID_TOOLS_CAPTURE_METADATA_H
#define RAYGRID_TOOLS_CAPTURE_METADATA_H

#include <optional>
#include <vector>

#include "calibration/operating_point_calibration.h"
#include "calibration_input.h"

namespace raygrid {

/// Capture conditions of images.
struct CaptureMetadata {
  /// Image times by camera, if the line delay is estimated.
  std::vector<std::optional<ImageTimes>> times;
  /// Lens positions or temperatures, if the intrinsics depend on them.
  std::optional<ImageOperatingPoints> conditions;
};

/// Reads the conditions once, because the input may be a pipe. Throws
/// Error(kUsage), InputError.
CaptureMetadata ReadCaptureMetadata(const CalibrateArguments& arguments,
                                    const std::vector<Measurements>& cameras);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CAPTURE_METADATA_H
