#ifndef RAYGRID_CALIBRATION_DIVERGENCE_H
#define RAYGRID_CALIBRATION_DIVERGENCE_H

#include "calibration/adjustment_result.h"

namespace raygrid {

/// Returns the limit of errors in comparisons of adjustments: 1/128 of the
/// longer side of the image.
double ErrorCapPx(const ImageSize& size);

/// Returns the mean over all features of `start` of the reprojection error, at
/// most ErrorCapPx(), which is also the error of features lost in `adjusted`.
double ComputeMeanErrorPx(const AdjustmentResult& adjusted,
                          const AdjustmentResult& start);

/// Error ratio above which a calibration is considered to have diverged.
constexpr double kDivergenceRatio = 1.2;

/// Returns whether a mean or median error exceeds another one by more than
/// kDivergenceRatio and by a relevant amount.
bool ExceedsDivergenceRatio(double error_px, double other_px);

/// Returns whether an adjustment is much worse than its initial state.
bool HasDiverged(const AdjustmentResult& adjusted,
                 const AdjustmentResult& start);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_DIVERGENCE_H
