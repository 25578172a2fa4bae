#ifndef RAYGRID_EVALUATION_FOLD_OVER_H
#define RAYGRID_EVALUATION_FOLD_OVER_H

#include "camera/camera_model.h"
#include "camera/camera_uncertainty.h"

namespace raygrid {

/// The part of the area where the camera is mirrored relative to most of the
/// area, so that two pixels share a ray (the distortion folds).
struct FoldOver {
  double part = 0;            ///< fraction of the area
  double valid_fraction = 0;  ///< folded fraction within the valid region
};

/// Measures the fold at the centres of square cells. null: no valid region.
FoldOver MeasureFoldOver(const CameraModel& camera,
                         const ValidityMask* valid_region);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_FOLD_OVER_H
