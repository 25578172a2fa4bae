#ifndef RAYGRID_CALIBRATION_MODEL_ADJUSTMENT_H
#define RAYGRID_CALIBRATION_MODEL_ADJUSTMENT_H

#include <string>
#include <vector>

#include "calibration/adjustment_result.h"

namespace raygrid {

/// Optimizes the requested model with rigid boards: optimization, outlier
/// removal, optimization. Grids are initialized from their base models. If this
/// diverges, other initial cameras are tried; if all diverge, the result is the
/// initial model, marked as not converged. knot_spacings_px: one per camera.
/// With `warm`, a warm start as in InitialValues with the same views, the first
/// optimization starts from its state and without its outliers.
void OptimizeWithRigidBoards(const Pattern& pattern, const std::string& model,
                             const std::vector<double>& knot_spacings_px,
                             const AdjustmentOptions& options,
                             AdjustmentResult* adjusted,
                             const AdjustmentResult* warm = nullptr);

/// Returns a single camera's result for some of its views, which must have a
/// separate pose each.
AdjustmentResult RemoveViewsAndPoses(const std::vector<bool>& remove,
                                     const AdjustmentResult& adjusted);

/// Enables board deformation. Requires that outliers were removed, since the
/// deformation would fit them. With a parametric model, the deformation would
/// absorb the model's systematic errors.
void EstimateDeformation(const Pattern& pattern,
                         const AdjustmentOptions& options,
                         AdjustmentResult* adjusted);

/// Performs the steps of OptimizeModel() after OptimizeWithRigidBoards().
void FinishModel(const Pattern& pattern, const std::string& model,
                 const AdjustmentOptions& options, AdjustmentResult* adjusted);

/// Runs all steps from the initial cameras to the requested model, up to
/// FinalizeCameras(), with one knot spacing per camera.
void OptimizeModel(const Pattern& pattern, const std::string& model,
                   const std::vector<double>& knot_spacings_px,
                   const AdjustmentOptions& options,
                   AdjustmentResult* adjusted);

/// Sets the quantities that no feature constrains: the area of parametric
/// cameras, control points without observations (limited to what a blob can
/// represent), and the origin of non-central cameras (the point nearest to all
/// observation lines).
void FinalizeCameras(AdjustmentResult* adjusted);

/// Aligns boards with estimated points to their nominal geometry.
void AlignBoards(const Pattern& pattern, AdjustmentResult* adjusted);

/// Estimates the flatness error of boards assumed flat in a calibration of
/// grids, or with known cameras: the RMS of the least flat board, in metres, if
/// they may deform. 0 unless the deformation is significant.
double EstimateFlatnessError(const Pattern& pattern,
                             const AdjustmentOptions& options,
                             AdjustmentResult adjusted);

/// Returns whether the estimated points differ from the nominal points by more
/// than an alignment; false if the prior suppressed any change.
bool HavePointsMoved(const AdjustmentResult& adjusted);

/// Returns the pattern with its estimated points.
Pattern MakeEstimatedPattern(const Pattern& pattern,
                             const AdjustmentResult& adjusted);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_MODEL_ADJUSTMENT_H
