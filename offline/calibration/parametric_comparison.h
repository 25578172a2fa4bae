#ifndef RAYGRID_CALIBRATION_PARAMETRIC_COMPARISON_H
#define RAYGRID_CALIBRATION_PARAMETRIC_COMPARISON_H

#include <optional>
#include <string>
#include <vector>

#include "calibration/calibration.h"
#include "calibration/cross_validation.h"
#include "calibration/model_adjustment.h"

namespace raygrid {

/// Every parametric model but the one that options are for, adjusted to the
/// training images from a parametric start, and tested with the images held
/// out; without such, by cross-validation. Models that cannot be adjusted are
/// left out.
std::vector<ModelFigures> CompareParametricModels(
    const Split& split, const Pattern& pattern,
    const CalibrationOptions& options, const Adjusted& start);

/// noncentral-generic beside a central grid, and central-generic beside a
/// parametric model, likewise: with cells of the same size, or larger where the
/// features do not tell so many parameters. Nothing if it cannot be adjusted.
std::optional<ModelFigures> TryAnotherGrid(const Split& split,
                                           const Pattern& pattern,
                                           const CalibrationOptions& options,
                                           const Adjusted& start,
                                           double cell_px);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_PARAMETRIC_COMPARISON_H
