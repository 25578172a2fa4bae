#ifndef RAYGRID_CALIBRATION_KNOT_SPACING_SELECTION_H
#define RAYGRID_CALIBRATION_KNOT_SPACING_SELECTION_H

#include <functional>
#include <string>
#include <vector>

#include "calibration/camera_in_progress.h"

namespace raygrid {

/// Cells as parts of the longer side, from coarse enough for a handful of
/// images to as fine as the features have equations for.
std::vector<double> ListKnotSpacings(const Dataset& dataset,
                                     const std::string& model);

/// Cells of a medium candidate, where none is chosen yet.
double MediumKnotSpacingPx(const Dataset& dataset, const std::string& model);

/// The loss of cells by the held-out residuals over all folds.
KnotSpacingCandidate SummarizeCandidate(
    double knot_spacing_px, const std::vector<FeatureResidual>& held_out);

/// Chooses the resolution of a camera's grid by the held-out loss of
/// cross-validation. The coarsest of all for few images, and after a stop.
void SelectKnotSpacing(const Pattern& pattern,
                       const CalibrationOptions& options,
                       const std::function<void(double)>& progress,
                       CameraInProgress* camera);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_KNOT_SPACING_SELECTION_H
