#ifndef RAYGRID_ADJUSTMENT_MATERN_FIELD_H
#define RAYGRID_ADJUSTMENT_MATERN_FIELD_H

#include <cmath>

namespace raygrid {

/// The order of the precision (kappa^2 - Laplacian)^kMaternOrder of a Matern
/// field, whose smoothness is one less (Lindgren, Rue, Lindstrom, "An explicit
/// link between Gaussian fields and Gaussian Markov random fields", 2011). It
/// is discretized by differences of orders 0 to kMaternOrder.
constexpr int kMaternOrder = 3;

/// Returns kappa in units of 1 / knot spacing, for a correlation range sqrt(8
/// (kMaternOrder - 1)) / kappa of half the extent.
inline double MaternKappa(double extent, double cell) {
  constexpr double kRelativeRange = 0.5;
  return std::sqrt(8.0 * (kMaternOrder - 1)) / (kRelativeRange * extent) * cell;
}

inline double Binomial(int n, int k) {
  return k == 0 ? 1 : Binomial(n - 1, k - 1) * n / k;
}

/// Returns a coefficient of finite differences: 1; -1 1; 1 -2 1; ...
inline double DifferenceFactor(int order, int index) {
  return Binomial(order, index) * ((order - index) % 2 == 0 ? 1 : -1);
}

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_MATERN_FIELD_H
