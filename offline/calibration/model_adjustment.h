#ifndef RAYGRID_CALIBRATION_MODEL_ADJUSTMENT_H
#define RAYGRID_CALIBRATION_MODEL_ADJUSTMENT_H

#include <string>
#include <vector>

#include "calibration/adjustment_result.h"

namespace raygrid {

/// Goes on to the model asked for, with boards that are rigid: adjusted,
/// outliers removed, once more. Grids start from the lenses that they lie
/// around. Where that diverges, other lenses are tried; if all fail, the camera
/// is as good as the lens that it started from, and has not converged. Cells
/// for each camera. Central grids start from those of another knot spacing, if
/// they are given.
void OptimizeWithRigidBoards(const Pattern& pattern, const std::string& model,
                             const std::vector<double>& knot_spacings_px,
                             const AdjustmentOptions& options,
                             AdjustmentResult* adjusted,
                             const AdjustmentResult* other_spacing = nullptr);

/// Goes on to boards that bend, once outliers are gone: bends would follow
/// them. With few parameters, as parametric models have, bends would take on
/// what these cannot follow of the lens.
void EstimateDeformation(const Pattern& pattern,
                         const AdjustmentOptions& options,
                         AdjustmentResult* adjusted);

/// All steps from starting lenses to the model asked for, with the options'
/// boards, as far as FinalizeCameras(). Cells for each camera.
void OptimizeModel(const Pattern& pattern, const std::string& model,
                   const std::vector<double>& knot_spacings_px,
                   const AdjustmentOptions& options,
                   AdjustmentResult* adjusted);

/// Settles after an adjustment what no feature tells: parametric cameras over
/// the calibrated area, unseen control points within what a blob can hold, the
/// origin of lines that do not meet at the point nearest to them.
void FinalizeCameras(AdjustmentResult* adjusted);

/// Brings boards whose points were free to where they are nominally.
void AlignBoards(const Pattern& pattern, AdjustmentResult* adjusted);

/// How far the boards of grids are from flat that were taken for flat: RMS of
/// the one that is farthest, metres, once they may bend. 0 unless they bend
/// more than chance would have it.
double EstimateFlatnessError(const Pattern& pattern,
                             const AdjustmentOptions& options,
                             AdjustmentResult adjusted);

/// False where the prior's strength kept the points as they are; then they were
/// no more than aligned.
bool HavePointsMoved(const AdjustmentResult& adjusted);

/// The pattern with its points where they were found to be.
Pattern MakeEstimatedPattern(const Pattern& pattern,
                             const AdjustmentResult& adjusted);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_MODEL_ADJUSTMENT_H
