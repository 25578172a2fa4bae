#ifndef RAYGRID_CALIBRATION_FRAME_ADJUSTMENT_H
#define RAYGRID_CALIBRATION_FRAME_ADJUSTMENT_H

#include "calibration/model_adjustment.h"

namespace raygrid {

/// Transforms adjusted cameras to their canonical frames
/// (camera/camera_frame.h), with priors, poses and relative poses, and
/// optimizes everything again, because a rotated spline is not exactly
/// representable on the same grid. Repeats this while cameras still need a
/// rotation; the last, small one does not change their shapes. Parametric
/// cameras are in their canonical frames already.
void OptimizeInCameraFrames(const AdjustmentOptions& options,
                            AdjustmentResult* adjusted);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_FRAME_ADJUSTMENT_H
