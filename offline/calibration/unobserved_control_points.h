#ifndef RAYGRID_CALIBRATION_UNOBSERVED_CONTROL_POINTS_H
#define RAYGRID_CALIBRATION_UNOBSERVED_CONTROL_POINTS_H

#include "calibration/calibration_problem.h"
#include "camera/camera_model.h"

namespace raygrid {

/// Limits control points without observations to 150 degrees from the axis. In
/// the corners around a fisheye's image circle only the smoothness prior
/// determines them, sometimes with almost backward directions, which a blob
/// cannot represent. Does not change other camera models.
void LimitUnobservedControlPoints(const CalibrationProblem& problem,
                                  int camera_index, CameraModel* camera);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_UNOBSERVED_CONTROL_POINTS_H
