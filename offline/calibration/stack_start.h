#ifndef RAYGRID_CALIBRATION_STACK_START_H
#define RAYGRID_CALIBRATION_STACK_START_H

#include "calibration/stack_calibration.h"

namespace raygrid {

/// A coarse stack from nothing but the observations: a lens from images whose
/// lens positions are near each other, or temperatures, then all images, with
/// the board as it is given.
CameraStack StartStack(const Dataset& dataset,
                       const ImageConditions& conditions,
                       const Pattern& pattern,
                       const CalibrationOptions& options);

/// The features where they would be in the middle of the stack's ranges. Those
/// that the camera there does not see are left out.
Dataset BringToMiddle(const Dataset& dataset, const ImageConditions& conditions,
                      const CameraStack& stack);

/// A stack on the grid of a camera, and in its frame, that changes with the
/// conditions as another one does. In the middle it is the camera.
CameraStack ChangesOnGrid(const CameraStack& stack,
                          const CentralGeneric& camera);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_STACK_START_H
