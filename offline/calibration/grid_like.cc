#include "calibration/grid_like.h"

#include "calibration/continued_lens.h"
#include "camera/nearest_rotation.h"
#include "camera/turned_camera.h"

namespace raygrid {

CentralGeneric GridLike(const CameraModel& like, const CameraModel& first_lens,
                        const Area& area, int columns, int rows) {
  return FitContinuedLens(
      TurnedCamera(like, NearestRotation(first_lens, like, area)), area,
      columns, rows);
}

}  // namespace raygrid
