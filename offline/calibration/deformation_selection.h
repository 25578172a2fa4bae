#ifndef RAYGRID_CALIBRATION_DEFORMATION_SELECTION_H
#define RAYGRID_CALIBRATION_DEFORMATION_SELECTION_H

#include "calibration/camera_in_progress.h"

namespace raygrid {

/// Returns whether a camera calibrated with board deformation predicts held-out
/// images better than one with rigid boards: better if the held-out boards may
/// deform, and also in the sum with the gain for rigid held-out boards, which
/// must not be a significant loss. Errors are dominated by the boards'
/// deformation, so they vary by chance. For a single camera.
bool IsDeformationBetter(const HeldOutResiduals& bent,
                         const HeldOutResiduals& rigid);

/// Decides from held-out errors whether boards may deform from image to image
/// during adjustment, and sets camera->per_view_deformation. False for
/// parametric models, and for fewer images than cross-validation needs. If true
/// and rigid boards led to a coarser knot spacing than the medium one, the knot
/// spacing is selected again.
void SelectDeformation(const Pattern& pattern,
                       const CalibrationOptions& options,
                       CameraInProgress* camera);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_DEFORMATION_SELECTION_H
