#ifndef RAYGRID_CALIBRATION_KNOT_SPACING_SELECTION_H
#define RAYGRID_CALIBRATION_KNOT_SPACING_SELECTION_H

#include <functional>
#include <string>
#include <vector>

#include "calibration/camera_in_progress.h"

namespace raygrid {

/// Lists knot spacings as fractions of the longer side, from coarse (for a
/// handful of images) to the finest that the number of features supports.
std::vector<double> ListKnotSpacings(const Dataset& dataset,
                                     const std::string& model);

/// Returns the medium knot spacing, the default before selection.
double MediumKnotSpacingPx(const Dataset& dataset, const std::string& model);

/// Computes a candidate's loss from held-out residuals over all folds.
KnotSpacingCandidate SummarizeCandidate(
    double knot_spacing_px, const std::vector<FeatureResidual>& held_out);

/// Selects a camera's knot spacing by the held-out loss of cross-validation.
/// Uses the coarsest one for few images, and after a stop.
void SelectKnotSpacing(const Pattern& pattern,
                       const CalibrationOptions& options,
                       const std::function<void(double)>& progress,
                       CameraInProgress* camera);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_KNOT_SPACING_SELECTION_H
