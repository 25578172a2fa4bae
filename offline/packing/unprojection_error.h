#ifndef RAYGRID_PACKING_UNPROJECTION_ERROR_H
#define RAYGRID_PACKING_UNPROJECTION_ERROR_H

#include <string>

#include "camera/camera_model.h"
#include "camera/camera_uncertainty.h"

namespace raygrid {

/// The largest errors that packing adds to un-projection: in pixels over
/// trusted cells, in radians over the whole area.
struct UnprojectionError {
  double px = 0, rad = 0;
};

/// A blob is measured against the camera where it is trusted, if it is
/// anywhere, and elsewhere against the grid that is left of it there.
struct PackingTruth {
  const CameraModel& camera;
  const CameraModel& elsewhere;
  const TrustMask* trusted;

  bool Trusts(const Eigen::Vector2d& pixel) const {
    return !trusted || trusted->Trusts(pixel);
  }
};

/// The runtime's un-projection by a blob against the truth, at every pixel of
/// the blob's area, or at those of every few rows and columns if these are more
/// than 16 million. In pixels it is measured where the camera is trusted, and
/// not where rays hardly turn from pixel to pixel, as outside a fisheye's image
/// circle. Throws Error(kQuality) if the runtime refuses the blob.
UnprojectionError MeasureUnprojection(const PackingTruth& truth,
                                      const std::string& blob, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_UNPROJECTION_ERROR_H
