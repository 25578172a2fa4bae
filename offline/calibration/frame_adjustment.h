#ifndef RAYGRID_CALIBRATION_FRAME_ADJUSTMENT_H
#define RAYGRID_CALIBRATION_FRAME_ADJUSTMENT_H

#include "calibration/model_adjustment.h"

namespace raygrid {

/// Brings adjusted cameras into the frames that they ought to have
/// (camera/camera_frame.h), with their priors, poses, and relative poses, and
/// adjusts all once more there, since a turned surface is not quite a surface
/// of the same grid; again where cameras then need a turn, and at last, when
/// that is small, without their shapes. Parametric cameras have their frames
/// already.
void OptimizeInCameraFrames(const AdjustmentOptions& options,
                            AdjustmentResult* adjusted);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_FRAME_ADJUSTMENT_H
