#ifndef RAYGRID_PACKING_UNPROJECTION_ERROR_H
#define RAYGRID_PACKING_UNPROJECTION_ERROR_H

#include <string>

#include "camera/camera_model.h"
#include "camera/camera_uncertainty.h"

namespace raygrid {

/// Maximum unprojection errors due to packing: in pixels over valid cells, in
/// radians over the whole area.
struct UnprojectionError {
  double px = 0, rad = 0;
};

/// The reference for measuring the errors of a blob: the camera within its
/// valid region, and the fitted grid elsewhere.
struct PackingTruth {
  const CameraModel& camera;
  const CameraModel& elsewhere;
  const ValidityMask* valid_region;

  bool IsValidAt(const Eigen::Vector2d& pixel) const {
    return !valid_region || valid_region->IsValidAt(pixel);
  }
};

/// Measures the runtime's unprojection by a blob against the truth, at every
/// pixel of the blob's area, subsampled to at most 16 million. Errors in pixels
/// are measured in the valid region, except where rays hardly change between
/// pixels, as outside a fisheye's image circle. Throws Error(kQualityTooLow) if
/// the runtime rejects the blob.
UnprojectionError MeasureUnprojection(const PackingTruth& truth,
                                      const std::string& blob, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_UNPROJECTION_ERROR_H
