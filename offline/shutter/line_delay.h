/// Line delay: the readout time per row of a rolling shutter.
#ifndef RAYGRID_SHUTTER_LINE_DELAY_H
#define RAYGRID_SHUTTER_LINE_DELAY_H

#include <vector>

#include "camera/camera_model.h"
#include "dataset/dataset.h"
#include "dataset/image_times.h"
#include "dataset/line_delay.h"

namespace raygrid {

/// A camera and views of boards in consecutive frames with known times.
struct MovingViews {
  const CameraModel* camera = nullptr;
  const Pattern* pattern = nullptr;
  const Dataset* dataset = nullptr;
  std::vector<BoardPose> poses;  ///< initial values, at the central row
  const ImageTimes* times = nullptr;
  /// Whether the camera was calibrated with rolling-shutter compensation.
  /// Otherwise, its bias makes the line delay vary within a recording.
  bool is_rolling_shutter_compensated = false;
};

/// Estimates the line delay. Images without a time, or without neighbours in
/// time, are not used.
LineDelayEstimate EstimateLineDelay(const MovingViews& views);

/// Compensates the rolling shutter: moves features to their positions at the
/// time of the central row; omits features that would be outside the image, and
/// features of frames without a motion estimate.
Dataset ComputeGlobalShutterFeatures(const MovingViews& views,
                                     double line_delay_s);

}  // namespace raygrid

#endif  // RAYGRID_SHUTTER_LINE_DELAY_H
