#ifndef RAYGRID_FLEET_AREA_POLYNOMIALS_H
#define RAYGRID_FLEET_AREA_POLYNOMIALS_H

#include <Eigen/Core>

#include "camera/area.h"

namespace raygrid {

/// Returns the number of polynomials of EvaluatePolynomials() up to a degree.
constexpr int NumPolynomials(int degree) {
  return (degree + 1) * (degree + 2) / 2;
}

/// Evaluates products of Legendre polynomials of a pixel's position in an area,
/// up to a degree: 1, x, y, x^2, ...; coordinates are scaled to -1 to 1.
Eigen::VectorXd EvaluatePolynomials(const Area& area,
                                    const Eigen::Vector2d& pixel, int degree);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_AREA_POLYNOMIALS_H
