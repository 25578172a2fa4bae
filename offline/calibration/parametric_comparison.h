#ifndef RAYGRID_CALIBRATION_PARAMETRIC_COMPARISON_H
#define RAYGRID_CALIBRATION_PARAMETRIC_COMPARISON_H

#include <functional>
#include <optional>
#include <vector>

#include "calibration/camera_in_progress.h"

namespace raygrid {

/// Every parametric model but the one that options are for, adjusted to the
/// training images from a parametric start, and tested with the images held
/// out; without such, by cross-validation. Models that cannot be adjusted are
/// left out. Other work for the camera is done beside them, with half of the
/// threads: beside(num_threads) is called once.
std::vector<ModelMetrics> CompareParametricModels(
    const CameraInProgress& camera, const Pattern& pattern,
    const CalibrationOptions& options,
    const std::function<void(int num_threads)>& beside);

/// noncentral-generic beside a central grid, and central-generic beside a
/// parametric model, likewise: with cells of the same size, or larger where the
/// features do not tell so many parameters. Nothing if it cannot be adjusted.
std::optional<ModelMetrics> CompareAlternativeGrid(
    const CameraInProgress& camera, const Pattern& pattern,
    const CalibrationOptions& options);

/// The part of the median held-out error that a richer model, a grid beside a
/// parametric model or a non-central one beside a central one, does not have:
/// the root of the difference of squares. Nothing if none is better by two
/// standard errors. Standard deviations do not contain it, since all images
/// share it.
std::optional<double> EstimateModelErrorPx(const CalibrationResult& result);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_PARAMETRIC_COMPARISON_H
