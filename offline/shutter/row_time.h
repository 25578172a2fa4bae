/// The time of a row: how much later than the row above a sensor reads it.
#ifndef RAYGRID_SHUTTER_ROW_TIME_H
#define RAYGRID_SHUTTER_ROW_TIME_H

#include <vector>

#include "camera/camera_model.h"
#include "dataset/dataset.h"
#include "dataset/image_times.h"
#include "dataset/row_time.h"

namespace raygrid {

/// A camera, and the boards in consecutive frames, whose times are known.
struct MovingViews {
  const CameraModel* camera = nullptr;
  const Pattern* pattern = nullptr;
  const Dataset* dataset = nullptr;
  std::vector<BoardPose> poses;  ///< of the frame as a whole; a start
  const ImageTimes* times = nullptr;
  /// Whether the camera was calibrated without the motion of rows. One that is
  /// bent by it tells different row times by parts of a recording.
  bool is_camera_final = false;
};

/// Estimates the time of a row. Images without a time, and those whose
/// neighbours in time are missing, tell nothing.
RowTimeEstimate EstimateRowTime(const MovingViews& views);

/// The features where they would have been seen, had their frame been read at
/// one instant, that of its middle row; without those that would have been seen
/// outside the image then, and those of frames whose motion is not known.
Dataset WithoutRowMotion(const MovingViews& views, double row_time_s);

}  // namespace raygrid

#endif  // RAYGRID_SHUTTER_ROW_TIME_H
