#ifndef RAYGRID_CALIBRATION_OUTLIER_REMOVAL_H
#define RAYGRID_CALIBRATION_OUTLIER_REMOVAL_H

#include <vector>

#include "calibration/adjustment_result.h"

namespace raygrid {

/// Returns whether there are outliers: residuals above the third quartile + 6
/// interquartile ranges of their camera (paper's supplement, "Bundle adjustment
/// details"), or features without a projection.
bool HasOutliers(const std::vector<Residual>& residuals,
                 const CalibrationProblem& problem);

enum class RemovalResult { kNone, kSome, kPartOfArea };

/// Removes the outliers of the last adjustment from the problem permanently.
/// kPartOfArea: the area of the grids changed, as it depends on the features.
RemovalResult RemoveOutliers(const Pattern& pattern,
                             AdjustmentResult* adjusted);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_OUTLIER_REMOVAL_H
