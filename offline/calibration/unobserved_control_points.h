#ifndef RAYGRID_CALIBRATION_UNOBSERVED_CONTROL_POINTS_H
#define RAYGRID_CALIBRATION_UNOBSERVED_CONTROL_POINTS_H

#include "calibration/calibration_problem.h"
#include "camera/camera_model.h"

namespace raygrid {

/// In the corners around a fisheye's image circle, smoothness alone carries a
/// grid's control points, sometimes to directions almost straight backwards,
/// which no blob can hold. Those that no feature of the camera depends on are
/// brought back to 150 degrees from the axis. Leaves other cameras alone.
void LimitUnobservedControlPoints(const CalibrationProblem& problem,
                                  int camera_index, CameraModel* camera);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_UNOBSERVED_CONTROL_POINTS_H
