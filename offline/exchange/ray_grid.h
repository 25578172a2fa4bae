#ifndef RAYGRID_EXCHANGE_RAY_GRID_H
#define RAYGRID_EXCHANGE_RAY_GRID_H

#include <memory>
#include <string>

#include "camera/camera_model.h"
#include "exchange/table_format.h"

namespace raygrid {

/// A grid camera fitted to a table of rays.
struct RayGrid {
  std::unique_ptr<CameraModel> camera;
  int columns = 0, rows = 0;  ///< number of control points
  /// Projection errors of points on the table's rays at a distance of one
  /// metre.
  double rms_px = 0, max_px = 0;
  size_t num_pixels = 0;  ///< compared pixels
  /// RMS error at every second pixel of a grid fitted to the other pixels,
  /// which estimates the error between the table's pixels.
  double left_out_rms_px = 0;
  double fraction_without_rays = 0;
};

/// Fits the grid with the fewest control points whose RMS error is below 0.002
/// px, or is only slightly larger than the error of any larger grid. model:
/// central-generic, noncentral-generic, or empty (non-central if the lines do
/// not meet at the origin). Throws InputError, naming the table, if it is not a
/// camera in camera axes, and Error(kUsage) for other models.
RayGrid FitRayGrid(const RayTable& rays, const std::string& model,
                   int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_RAY_GRID_H
