#ifndef RAYGRID_CALIBRATION_OPERATING_POINT_INITIALIZATION_H
#define RAYGRID_CALIBRATION_OPERATING_POINT_INITIALIZATION_H

#include "calibration/operating_point_calibration.h"

namespace raygrid {

/// Estimates a coarse operating-point model from the observations alone: a
/// camera from images with similar lens positions or temperatures, then all
/// images, with the nominal target geometry.
OperatingPointModel InitializeOperatingPointModel(
    const Dataset& dataset, const ImageOperatingPoints& conditions,
    const Pattern& pattern, const CalibrationOptions& options);

/// Maps features to where they would be at the mid-range of the model. Features
/// that the mid-range camera cannot observe are omitted.
Dataset MapFeaturesToReference(const Dataset& dataset,
                               const ImageOperatingPoints& conditions,
                               const OperatingPointModel& stack);

/// Returns a model on the grid and in the frame of `camera`, with the
/// operating-point dependence of `stack`; it equals `camera` at the mid-range.
OperatingPointModel TransferTermsBetweenGrids(const OperatingPointModel& stack,
                                              const CentralGeneric& camera);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_OPERATING_POINT_INITIALIZATION_H
