#ifndef RAYGRID_CALIBRATION_PARAMETRIC_COMPARISON_H
#define RAYGRID_CALIBRATION_PARAMETRIC_COMPARISON_H

#include <functional>
#include <optional>
#include <vector>

#include "calibration/camera_in_progress.h"
#include "calibration/model_selection.h"

namespace raygrid {

/// Fits all parametric models other than the options' model to the training
/// images, and evaluates them with the held-out images or, without any, by
/// cross-validation. Models whose optimization fails are omitted. Other work
/// for the camera runs concurrently, with half of the threads:
/// beside(num_threads) is called once. Does not repeat `done` trials of the
/// camera's folds, which have the same options.
std::vector<ModelMetrics> CompareParametricModels(
    const CameraInProgress& camera, const Pattern& pattern,
    const CalibrationOptions& options, const ModelTrials& done,
    const std::function<void(int num_threads)>& beside);

/// Compares noncentral-generic with a central grid, or central-generic with a
/// parametric model, in the same way, with the same knot spacing, or a larger
/// one if there are too few features. Returns nullopt if the optimization
/// fails.
std::optional<ModelMetrics> CompareAlternativeGrid(
    const CameraInProgress& camera, const Pattern& pattern,
    const CalibrationOptions& options, const ModelTrials& done);

/// Estimates the model error: the fraction of the median held-out error that a
/// richer model (a grid instead of a parametric model, or a non-central instead
/// of a central one) removes, as the root of the difference of squares.
/// Predicted uncertainties do not include it, since it is common to all images.
/// Returns nullopt if no model is better by two standard errors.
std::optional<double> EstimateModelErrorPx(const CalibrationResult& result);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_PARAMETRIC_COMPARISON_H
