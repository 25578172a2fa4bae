#ifndef RAYGRID_CALIBRATION_PRIOR_GRID_H
#define RAYGRID_CALIBRATION_PRIOR_GRID_H

#include "camera/central_generic.h"

namespace raygrid {

/// Fits a grid over an area to a prior camera, rotated to the frame of a first
/// camera: a camera file may have any frame, but boards were localized with the
/// first camera. Beyond the prior camera's area the grid is extrapolated as by
/// FitExtrapolatedGrid().
CentralGeneric FitGridToPrior(const CameraModel& like,
                              const CameraModel& first_model, const Area& area,
                              int columns, int rows);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_PRIOR_GRID_H
