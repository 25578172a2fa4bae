#ifndef RAYGRID_CALIBRATION_POLYNOMIAL_GRID_H
#define RAYGRID_CALIBRATION_POLYNOMIAL_GRID_H

#include "camera/central_generic.h"

namespace raygrid {

/// The grid of the same control points that is closest to a polynomial of the
/// pixel, of fifth degree, in chart coordinates: what a lens of no kind is
/// expected to be around. A grid's details are what its features' errors made
/// of it, too. So a prior around the grid itself would hold these errors.
CentralGeneric FitPolynomialGrid(const CentralGeneric& grid);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_POLYNOMIAL_GRID_H
