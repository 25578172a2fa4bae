#ifndef RAYGRID_CAMERA_LENS_SPREAD_H
#define RAYGRID_CAMERA_LENS_SPREAD_H

#include <Eigen/Core>
#include <vector>

#include "camera/area.h"
#include "camera/bspline_surface.h"

namespace raygrid {

/// How units of a fleet differ from its middle camera: what a pixel of a unit
/// sees, the middle camera sees beside it, but for a turn, by about a sum of
/// these displacements, each times a standard normal number of the unit's own.
/// On a lattice from corner to corner of the camera's area, row by row, smooth
/// between.
struct LensSpread {
  int columns = 0, rows = 0;  ///< 4 or more
  std::vector<std::vector<Eigen::Vector2d>> displacements_px;

  /// The lattice's places, row by row.
  std::vector<Eigen::Vector2d> Places(const Area& area) const;
  /// Each displacement as a surface over the area, in pixels.
  std::vector<BSplineSurface> Surfaces(const Area& area) const;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_LENS_SPREAD_H
