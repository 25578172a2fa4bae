#ifndef RAYGRID_CALIBRATION_PRIOR_GRID_H
#define RAYGRID_CALIBRATION_PRIOR_GRID_H

#include "camera/central_generic.h"

namespace raygrid {

/// A grid over an area that sees what another camera sees, of a like lens,
/// turned to where a first lens looks: a camera file may have any frame, but
/// boards were localised with the first lens. Beyond the other camera's area
/// the grid goes on as FitExtrapolatedGrid() does.
CentralGeneric FitGridToPrior(const CameraModel& like,
                              const CameraModel& first_lens, const Area& area,
                              int columns, int rows);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_PRIOR_GRID_H
