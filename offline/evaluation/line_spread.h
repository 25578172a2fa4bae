#ifndef RAYGRID_EVALUATION_LINE_SPREAD_H
#define RAYGRID_EVALUATION_LINE_SPREAD_H

#include <Eigen/Core>

#include "camera/camera_model.h"

namespace raygrid {

/// How far a camera's lines pass by the point that is nearest to all of them:
/// zero for a central camera.
struct LineSpread {
  Eigen::Vector3d nearest_point = Eigen::Vector3d::Zero();
  double rms_m = 0, max_m = 0;
};

/// The spread of lines all over the area.
LineSpread MeasureLineSpread(const CameraModel& camera);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_LINE_SPREAD_H
