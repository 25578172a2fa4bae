#ifndef RAYGRID_CALIBRATION_DEFORMATION_SHARE_H
#define RAYGRID_CALIBRATION_DEFORMATION_SHARE_H

#include "calibration/model_adjustment.h"

namespace raygrid {

/// Computes the fraction of the squared residuals of cameras with rigid boards
/// that per-view deformation would explain, to first order, beyond its expected
/// fraction of white noise. About 0, or slightly negative, without deformation.
/// Uses views with at least 18 features, the number of pose and deformation
/// parameters; 1 if there are none.
double ComputeDeformationShare(const AdjustmentResult& adjusted,
                               int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_DEFORMATION_SHARE_H
