#ifndef RAYGRID_CALIBRATION_RIG_CALIBRATION_H
#define RAYGRID_CALIBRATION_RIG_CALIBRATION_H

#include <optional>
#include <string>
#include <vector>

#include "calibration/calibration.h"
#include "evaluation/rig_result.h"

namespace raygrid {

/// A camera of a rig and what it saw.
struct RigCameraInput {
  std::string name;
  Dataset dataset;
  MeasureAgain measure_again;        ///< without: features stay as they are
  std::optional<Checkpoint> resume;  ///< of the same features and options
  KeepCheckpoint keep = nullptr;
  std::vector<RejectedImage> skipped = {};  ///< given, but not measured
};

/// From the features of cameras on a rig to cameras and their poses: each
/// camera started alone, then put together and adjusted together. Images of one
/// name show one instant; options.hold_out names instants. Throws Error:
/// kUsage, kTooFew, kInitialization.
RigResult CalibrateRig(const std::vector<RigCameraInput>& cameras,
                       const Pattern& pattern,
                       const CalibrationOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RIG_CALIBRATION_H
