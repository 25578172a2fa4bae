#ifndef RAYGRID_PACKING_PROJECTION_ERROR_H
#define RAYGRID_PACKING_PROJECTION_ERROR_H

#include <algorithm>
#include <cstdint>

#include "camera/camera_uncertainty.h"
#include "packing/blob_camera.h"

namespace raygrid {

/// How many pixels the runtime's projection finds again by what they see.
struct FoundPixels {
  int64_t num_pixels = 0;      ///< of those that can be found
  int64_t num_unfindable = 0;  ///< where the surface is folded, or looks 151
                               ///< degrees from the z axis or more
  int64_t num_lost = 0;        ///< not seen
  int64_t num_off = 0;         ///< by more than kMaxProjectionErrorPx
  double worst_px = 0;         ///< of those seen

  bool AreAllFound() const { return num_lost == 0 && num_off == 0; }
  /// The part lost or off.
  double MissedPart() const {
    return static_cast<double>(num_lost + num_off) /
           std::max<int64_t>(num_pixels, 1);
  }
};

struct ProjectionError {
  FoundPixels trusted;  ///< of the whole area if there is no mask
  FoundPixels others;
};

/// How far from the z axis the runtime looks, in the chart: tan(151 / 2
/// degrees), less a little.
constexpr double kMaxChartRadius = 3.85;

/// The largest error that the runtime's projection may have.
constexpr double kMaxProjectionErrorPx = 0.002;

/// Measures the projection over the pixels of the area and its edge, or, if
/// these are more than max_pixels, those of every few rows and columns, against
/// the blob's own surface in double precision. The blob has an inverse grid.
ProjectionError MeasureProjection(const BlobCamera& blob,
                                  const TrustMask* trusted, double max_pixels,
                                  int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_PROJECTION_ERROR_H
