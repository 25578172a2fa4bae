#ifndef RAYGRID_CALIBRATION_OPERATING_POINT_INITIALIZATION_H
#define RAYGRID_CALIBRATION_OPERATING_POINT_INITIALIZATION_H

#include "calibration/operating_point_calibration.h"

namespace raygrid {

/// A coarse stack from nothing but the observations: a lens from images whose
/// lens positions are near each other, or temperatures, then all images, with
/// the board as it is given.
OperatingPointModel InitializeOperatingPointModel(
    const Dataset& dataset, const ImageOperatingPoints& conditions,
    const Pattern& pattern, const CalibrationOptions& options);

/// The features where they would be in the middle of the stack's ranges. Those
/// that the camera there does not see are left out.
Dataset MapFeaturesToReference(const Dataset& dataset,
                               const ImageOperatingPoints& conditions,
                               const OperatingPointModel& stack);

/// A stack on the grid of a camera, and in its frame, that changes with the
/// conditions as another one does. In the middle it is the camera.
OperatingPointModel TransferChanges(const OperatingPointModel& stack,
                                    const CentralGeneric& camera);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_OPERATING_POINT_INITIALIZATION_H
