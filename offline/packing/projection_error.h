#ifndef RAYGRID_PACKING_PROJECTION_ERROR_H
#define RAYGRID_PACKING_PROJECTION_ERROR_H

#include <algorithm>
#include <cstdint>

#include "camera/camera_uncertainty.h"
#include "packing/blob_camera.h"

namespace raygrid {

/// Result of projecting the rays of pixels with the runtime.
struct ProjectedPixels {
  int64_t num_pixels = 0;          ///< pixels with a unique projection
  int64_t num_not_invertible = 0;  ///< at folds of the surface, or 151
                                   ///< degrees from the z axis or more
  int64_t num_not_converged = 0;   ///< projection does not converge
  int64_t num_inaccurate = 0;      ///< errors above kMaxProjectionErrorPx
  double worst_px = 0;             ///< maximum error of found pixels

  bool AreAllAccurate() const {
    return num_not_converged == 0 && num_inaccurate == 0;
  }
  /// Returns the fraction of pixels that are not found or inaccurate.
  double FailedFraction() const {
    return static_cast<double>(num_not_converged + num_inaccurate) /
           std::max<int64_t>(num_pixels, 1);
  }
};

struct ProjectionError {
  ProjectedPixels valid_region;  ///< valid region; the area without a mask
  ProjectedPixels others;
};

/// Maximum radius in the runtime's chart: tan(151 / 2 degrees), less a margin.
constexpr double kMaxChartRadius = 3.85;

/// Maximum error of the runtime's projection.
constexpr double kMaxProjectionErrorPx = 0.002;

/// Measures projection over the pixels of the area and its edge, subsampled to
/// at most max_pixels, relative to the blob's own surface in double precision.
/// The blob must have an inverse grid.
ProjectionError MeasureProjection(const BlobCamera& blob,
                                  const ValidityMask* valid_region,
                                  double max_pixels, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_PROJECTION_ERROR_H
