#ifndef RAYGRID_CALIBRATION_OUTLIER_REMOVAL_H
#define RAYGRID_CALIBRATION_OUTLIER_REMOVAL_H

#include <vector>

#include "calibration/adjustment_result.h"

namespace raygrid {

/// Outliers are residuals beyond the third quartile + 6 interquartile ranges of
/// their camera's (paper's supplement, "Bundle adjustment details"), and
/// features that do not project.
bool HasOutliers(const std::vector<Residual>& residuals,
                 const CalibrationProblem& problem);

enum class RemovalResult { kNone, kSome, kPartOfArea };

/// Removes the outliers of the last adjustment from the problem, for good.
/// kPartOfArea: the area of the grids has changed, which features may span.
RemovalResult RemoveOutliers(const Pattern& pattern,
                             AdjustmentResult* adjusted);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_OUTLIER_REMOVAL_H
