#ifndef RAYGRID_CALIBRATION_POLYNOMIAL_GRID_H
#define RAYGRID_CALIBRATION_POLYNOMIAL_GRID_H

#include "camera/central_generic.h"

namespace raygrid {

/// Fits a fifth-degree polynomial of the pixel, in chart coordinates, on the
/// same control points. It is the prior mean without a parametric model: the
/// details of a grid contain the feature noise that it was fitted to, so a
/// prior centred on the grid itself would preserve the noise.
CentralGeneric FitPolynomialGrid(const CentralGeneric& grid);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_POLYNOMIAL_GRID_H
