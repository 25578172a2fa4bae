#ifndef RAYGRID_CALIBRATION_DIVERGENCE_H
#define RAYGRID_CALIBRATION_DIVERGENCE_H

#include "calibration/adjustment_result.h"

namespace raygrid {

/// The largest error that counts where adjustments are compared: 1/128 of the
/// image's longer side.
double ErrorCapPx(const ImageSize& size);

/// The mean reprojection error over all features of a start, each no more than
/// ErrorCapPx(), which those have that an adjustment lost.
double ComputeMeanErrorPx(const AdjustmentResult& adjusted,
                          const AdjustmentResult& start);

/// The ratio of errors from which on a calibration is taken to have been led
/// astray.
constexpr double kDivergenceRatio = 1.2;

/// Whether a mean or median error is more than kDivergenceRatio of another one,
/// and not by next to nothing.
bool ExceedsDivergenceRatio(double error_px, double other_px);

/// Whether an adjustment went from a start to something that is much worse.
bool HasDiverged(const AdjustmentResult& adjusted,
                 const AdjustmentResult& start);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_DIVERGENCE_H
