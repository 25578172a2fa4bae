#include "calibration/polynomial_grid.h"

#include <Eigen/Cholesky>
#include <vector>

namespace raygrid {
namespace {

// Polynomial degree for cameras without an optical axis. Degree 3 has larger
// errors than 5, both in corners without features and elsewhere
// (offline/calibration/DESIGN.md).
constexpr int kDegree = 5;
constexpr int kNumPolynomials = (kDegree + 1) * (kDegree + 2) / 2;
using Polynomials = Eigen::Matrix<double, kNumPolynomials, 1>;

// Returns the products of Chebyshev polynomials in pixel coordinates that are
// normalized to [-1, 1]^2.
Polynomials EvaluatePolynomials(const Eigen::Vector2d& pixel,
                                const Area& area) {
  const double at[2] = {(pixel.x() - area.center().x()) / (area.width() / 2),
                        (pixel.y() - area.center().y()) / (area.height() / 2)};
  double one[2][kDegree + 1];
  for (int k = 0; k < 2; ++k) {
    one[k][0] = 1;
    one[k][1] = at[k];
    for (int n = 2; n <= kDegree; ++n)
      one[k][n] = 2 * at[k] * one[k][n - 1] - one[k][n - 2];
  }
  Polynomials products;
  int index = 0;
  for (int degree = 0; degree <= kDegree; ++degree)
    for (int y = 0; y <= degree; ++y)
      products[index++] = one[0][degree - y] * one[1][y];
  return products;
}

}  // namespace

CentralGeneric FitPolynomialGrid(const CentralGeneric& grid) {
  constexpr int kPerCell = 4;
  const BSplineSurface& surface = grid.surface();
  const Area& area = surface.area();
  const std::vector<Eigen::Vector2d> pixels = surface.SamplePixels(kPerCell);
  using Normal = Eigen::Matrix<double, kNumPolynomials, kNumPolynomials>;
  using Right = Eigen::Matrix<double, kNumPolynomials, 2>;
  Normal normal = Normal::Zero();
  Right right = Right::Zero();
  for (const Eigen::Vector2d& pixel : pixels) {
    const Polynomials products = EvaluatePolynomials(pixel, area);
    normal += products * products.transpose();
    right += products * surface.Evaluate(pixel).transpose();
  }
  const Right coefficients = normal.ldlt().solve(right);
  std::vector<SurfaceSample> samples;
  for (const Eigen::Vector2d& pixel : pixels)
    samples.push_back(
        {pixel, coefficients.transpose() * EvaluatePolynomials(pixel, area)});
  return CentralGeneric(grid.image_size(), FitSurface(area, surface.columns(),
                                                      surface.rows(), samples));
}

}  // namespace raygrid
