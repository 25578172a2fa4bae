#ifndef RAYGRID_CALIBRATION_DEFORMATION_SELECTION_H
#define RAYGRID_CALIBRATION_DEFORMATION_SELECTION_H

#include "calibration/camera_in_progress.h"

namespace raygrid {

/// Returns whether a camera calibrated with board deformation predicts held-out
/// images better than one with rigid boards. Held-out images are evaluated with
/// rigid boards, and with boards that may deform. The latter errors must
/// decrease, the former must not increase significantly, and the sum of both
/// z-scores (ComputeLossGain()) must show an improvement. The errors vary by
/// chance, because the deformation of the boards dominates them. For a single
/// camera.
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
