#ifndef RAYGRID_CAMERA_POPULATION_COVARIANCE_H
#define RAYGRID_CAMERA_POPULATION_COVARIANCE_H

#include <Eigen/Core>
#include <vector>

#include "camera/area.h"
#include "camera/bspline_surface.h"

namespace raygrid {

/// Variation of a fleet's units around its population mean: up to a rotation, a
/// unit's rays are displaced in the mean camera's image by a sum of these
/// displacement fields, each multiplied by an independent standard normal
/// variable. On a lattice from corner to corner of the camera's area, row by
/// row, with smooth interpolation.
struct PopulationCovariance {
  int columns = 0, rows = 0;  ///< at least 4
  std::vector<std::vector<Eigen::Vector2d>> displacements_px;

  /// Returns the lattice's pixels, row by row.
  std::vector<Eigen::Vector2d> GetPositions(const Area& area) const;
  /// Returns each displacement field as a surface over the area, in pixels.
  std::vector<BSplineSurface> FitSurfaces(const Area& area) const;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_POPULATION_COVARIANCE_H
