#ifndef RAYGRID_SIMULATION_OBSERVATION_LINES_H
#define RAYGRID_SIMULATION_OBSERVATION_LINES_H

#include <string>

#include "camera/camera_model.h"

namespace raygrid {

/// Formats true_lines.csv: the exact lines of 33 x 25 pixels from corner to
/// corner of the image, as x,y,dx,dy,dz,ox,oy,oz: pixel, unit direction, point
/// in metres. Fields are empty where there is no line.
std::string FormatObservationLines(const CameraModel& camera);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_OBSERVATION_LINES_H
