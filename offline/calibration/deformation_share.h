#ifndef RAYGRID_CALIBRATION_DEFORMATION_SHARE_H
#define RAYGRID_CALIBRATION_DEFORMATION_SHARE_H

#include "calibration/model_adjustment.h"

namespace raygrid {

/// The part of the squared residuals of cameras with rigid boards that bends of
/// each view's board would take away, to first order, beyond what they take of
/// noise that features do not share. About 0, and a little below it by chance,
/// if boards do not bend. Told by views of at least 18 features, one for each
/// parameter of their poses and bends; 1 if there are none.
double ComputeDeformationShare(const AdjustmentResult& adjusted,
                               int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_DEFORMATION_SHARE_H
