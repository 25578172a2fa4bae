#ifndef RAYGRID_CALIBRATION_EXTRAPOLATED_GRID_H
#define RAYGRID_CALIBRATION_EXTRAPOLATED_GRID_H

#include "camera/central_generic.h"

namespace raygrid {

/// A grid over an area, closest to a lens as far as it has directions, up to
/// 130 degrees from its axis. Farther out, as in the corners around a fisheye's
/// image circle, there is nothing to see and a polynomial goes astray: the grid
/// goes on smoothly there, drawn towards where the lens would with the slope
/// that it ends with, which fades away towards 132 degrees.
CentralGeneric FitExtrapolatedGrid(const CameraModel& lens, const Area& area,
                                   int columns, int rows);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_EXTRAPOLATED_GRID_H
