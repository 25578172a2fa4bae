#ifndef RAYGRID_DATASET_FIXED_OPERATING_POINT_H
#define RAYGRID_DATASET_FIXED_OPERATING_POINT_H

#include <optional>

#include "dataset/camera_file.h"

namespace raygrid {

/// Restricts an operating-point model to the conditions that are not held.
/// Standard deviations are interpolated linearly between known values.
OperatingPointCalibration FixOperatingPoint(
    const OperatingPointCalibration& stack, const FixedOperatingPoint& at);
/// Restricts the model to one condition, with the others at mid-range.
OperatingPointCalibration SliceOperatingPointModel(
    const OperatingPointCalibration& stack, size_t range);

/// The file of the camera at fixed values of conditions, which are recorded as
/// its capture settings. Contains an operating-point model over the remaining
/// conditions, if any. A cell is valid if it is in the middle of the ranges,
/// and if its standard deviation at the values is small enough.
CameraFile MakeCameraFileAt(const CameraFile& stack,
                            const FixedOperatingPoint& at);

/// The uncertainty over all operating points: at each position, the maximum
/// standard deviation; cells are valid if they are at all values.
std::optional<CameraUncertainty> ComputeMaxUncertainty(const CameraFile& stack);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_FIXED_OPERATING_POINT_H
