#ifndef RAYGRID_PACKING_PROJECTION_ERROR_H
#define RAYGRID_PACKING_PROJECTION_ERROR_H

#include <algorithm>
#include <cstdint>

#include "camera/camera_uncertainty.h"
#include "packing/blob_camera.h"

namespace raygrid {

/// The number of pixels that the runtime finds by projecting their rays.
struct FoundPixels {
  int64_t num_pixels = 0;      ///< with a unique projection
  int64_t num_unfindable = 0;  ///< where the surface folds, or 151
                               ///< degrees from the z axis or more
  int64_t num_lost = 0;        ///< projection fails
  int64_t num_off = 0;         ///< by more than kMaxProjectionErrorPx
  double worst_px = 0;         ///< of those found

  bool AreAllFound() const { return num_lost == 0 && num_off == 0; }
  /// The fraction lost or off.
  double MissedFraction() const {
    return static_cast<double>(num_lost + num_off) /
           std::max<int64_t>(num_pixels, 1);
  }
};

struct ProjectionError {
  FoundPixels trusted;  ///< of the whole area without a mask
  FoundPixels others;
};

/// The maximum radius in the runtime's chart: tan(151 / 2 degrees), less a
/// margin.
constexpr double kMaxChartRadius = 3.85;

/// Limit of the runtime's projection error.
constexpr double kMaxProjectionErrorPx = 0.002;

/// Measures projection over the pixels of the area and its edge, subsampled to
/// at most max_pixels, against the blob's own surface in double precision. The
/// blob must have an inverse grid.
ProjectionError MeasureProjection(const BlobCamera& blob,
                                  const ValidityMask* trusted,
                                  double max_pixels, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_PROJECTION_ERROR_H
