#ifndef RAYGRID_SIMULATION_OBSERVATION_LINES_H
#define RAYGRID_SIMULATION_OBSERVATION_LINES_H

#include <string>

#include "camera/camera_model.h"

namespace raygrid {

/// true_lines.csv: the exact lines of 33 x 25 pixels from corner to corner of
/// the image, as x,y,dx,dy,dz,ox,oy,oz: the pixel, the unit direction, a point
/// in metres. Empty fields where there is no line.
std::string FormatObservationLines(const CameraModel& camera);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_OBSERVATION_LINES_H
