#ifndef RAYGRID_CALIBRATION_DEFORMATION_SHARE_H
#define RAYGRID_CALIBRATION_DEFORMATION_SHARE_H

#include "calibration/model_adjustment.h"

namespace raygrid {

/// Computes the fraction of the squared residuals of cameras with rigid boards
/// that per-view deformation would explain to first order, less the fraction
/// expected for white noise. About 0, or slightly negative, without
/// deformation. Uses views with at least 18 features, the number of pose and
/// deformation parameters; 1 without such views.
double ComputeDeformationShare(const AdjustmentResult& adjusted,
                               int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_DEFORMATION_SHARE_H
