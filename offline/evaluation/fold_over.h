#ifndef RAYGRID_EVALUATION_FOLD_OVER_H
#define RAYGRID_EVALUATION_FOLD_OVER_H

#include "camera/camera_model.h"
#include "camera/camera_uncertainty.h"

namespace raygrid {

/// The part of a camera that is mirrored against most of its area, so that two
/// pixels look along one ray.
struct FoldOver {
  double part = 0;          ///< of the area
  double trusted_part = 0;  ///< of the area: folded and trusted
};

/// Measures the fold by the middles of square cells of the area. nullptr trusts
/// none.
FoldOver MeasureFoldOver(const CameraModel& camera, const TrustMask* trusted);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_FOLD_OVER_H
