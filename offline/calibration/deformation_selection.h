#ifndef RAYGRID_CALIBRATION_DEFORMATION_SELECTION_H
#define RAYGRID_CALIBRATION_DEFORMATION_SELECTION_H

#include "calibration/camera_in_progress.h"

namespace raygrid {

/// Whether a camera of boards that bend predicts held-out images better than
/// one of rigid boards: where their boards may bend, and in the sum of that
/// gain and the one where they may not, which must not surely be a loss. These
/// errors are mostly the boards' own bends, so they differ by chance.
/// HeldOutResiduals is of one camera.
bool IsDeformationBetter(const HeldOutResiduals& bent,
                         const HeldOutResiduals& rigid);

/// Decides whether boards may bend from image to image while a camera is
/// adjusted, by how that camera and one of rigid boards predict held-out
/// images. They may not with a parametric model, nor with fewer images than
/// cross-validation needs. Sets camera->per_view_deformation. If they may,
/// cells of the grid that rigid boards chose coarser than the medium ones are
/// chosen again.
void SelectDeformation(const Pattern& pattern,
                       const CalibrationOptions& options,
                       CameraInProgress* camera);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_DEFORMATION_SELECTION_H
