#include "calibration/prior_grid.h"

#include "calibration/extrapolated_grid.h"
#include "camera/nearest_rotation.h"
#include "camera/rotated_camera.h"

namespace raygrid {

CentralGeneric FitGridToPrior(const CameraModel& like,
                              const CameraModel& first_model, const Area& area,
                              int columns, int rows) {
  return FitExtrapolatedGrid(
      RotatedCamera(like, ComputeNearestRotation(first_model, like, area)),
      area, columns, rows);
}

}  // namespace raygrid
