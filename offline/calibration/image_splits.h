#ifndef RAYGRID_CALIBRATION_IMAGE_SPLITS_H
#define RAYGRID_CALIBRATION_IMAGE_SPLITS_H

#include <set>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "evaluation/calibration_result.h"

namespace raygrid {

using ImageNames = std::set<std::string>;

/// Returns the names of the images of a dataset, in its order.
std::vector<std::string> ListImageNames(const Dataset& dataset);

/// Proposes splits of the images into two groups that differ systematically,
/// each by the names of one group: two kinds of names (left01.jpg,
/// right01.jpg); or else the signs of the residual fields along their first
/// principal directions, and the first half of the sorted names.
std::vector<ImageNames> ListSplitsToTry(
    const Dataset& dataset, const std::vector<FeatureResidual>& residuals);

/// Returns whether the residuals of neighbouring features are correlated.
bool HasCorrelatedErrors(const std::vector<FeatureResidual>& residuals);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_IMAGE_SPLITS_H
