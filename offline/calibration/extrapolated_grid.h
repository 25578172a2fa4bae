#ifndef RAYGRID_CALIBRATION_EXTRAPOLATED_GRID_H
#define RAYGRID_CALIBRATION_EXTRAPOLATED_GRID_H

#include "camera/central_generic.h"

namespace raygrid {

/// Fits a grid over an area to a camera, up to 130 degrees from its axis or as
/// far as it has directions. Farther out, as in the corners around a fisheye's
/// image circle, there are no observations and polynomials diverge: the grid is
/// extrapolated smoothly, weakly attracted to a continuation of the camera
/// whose slope decays towards 132 degrees.
CentralGeneric FitExtrapolatedGrid(const CameraModel& lens, const Area& area,
                                   int columns, int rows);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_EXTRAPOLATED_GRID_H
