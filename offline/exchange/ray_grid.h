#ifndef RAYGRID_EXCHANGE_RAY_GRID_H
#define RAYGRID_EXCHANGE_RAY_GRID_H

#include <memory>
#include <string>

#include "camera/camera_model.h"
#include "exchange/table_format.h"

namespace raygrid {

/// A grid camera of a table of rays.
struct RayGrid {
  std::unique_ptr<CameraModel> camera;
  int columns = 0, rows = 0;  ///< of control points
  /// How far the camera sees points of the table's rays from their pixels; the
  /// points are a metre away.
  double rms_px = 0, max_px = 0;
  size_t num_pixels = 0;  ///< that were compared
  /// RMS at every second pixel, of a grid that was fitted to the others: how
  /// far off the camera may be between the table's pixels.
  double left_out_rms_px = 0;
  double part_without_rays = 0;
};

/// The grid camera of the fewest control points that leaves less than 0.002 px
/// (RMS), or hardly more than any other one does. model is central-generic,
/// noncentral-generic, or empty: the latter if the lines do not meet at the
/// origin. Throws InputError, naming the table, if it is no camera in camera
/// axes, and Error(kUsage) for other models.
RayGrid FitRayGrid(const RayTable& rays, const std::string& model,
                   int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_RAY_GRID_H
