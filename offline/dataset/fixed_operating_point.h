#ifndef RAYGRID_DATASET_FIXED_OPERATING_POINT_H
#define RAYGRID_DATASET_FIXED_OPERATING_POINT_H

#include <optional>

#include "dataset/camera_file.h"

namespace raygrid {

/// Restricts an operating-point model to the variables that are not fixed.
/// Standard deviations are interpolated linearly between known values.
OperatingPointCalibration FixOperatingPoint(
    const OperatingPointCalibration& stack, const FixedOperatingPoint& at);
/// Restricts the model to one variable, with the other at mid-range.
OperatingPointCalibration SliceOperatingPointModel(
    const OperatingPointCalibration& stack, size_t range);

/// Makes the file of the camera at fixed operating-point variables, which are
/// recorded as its capture settings. Contains an operating-point model over the
/// remaining variables, if any. A cell is valid if it is valid at mid-range,
/// and its standard deviation at the fixed values is small enough.
CameraFile MakeCameraFileAt(const CameraFile& stack,
                            const FixedOperatingPoint& at);

/// Computes the uncertainty over all operating points: at each position, the
/// maximum standard deviation; cells that are valid at all values are valid.
std::optional<CameraUncertainty> ComputeMaxUncertainty(const CameraFile& stack);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_FIXED_OPERATING_POINT_H
