#include "fleet/area_polynomials.h"

#include <vector>

namespace raygrid {

Eigen::VectorXd EvaluatePolynomials(const Area& area,
                                    const Eigen::Vector2d& pixel, int degree) {
  const Eigen::Array2d position = 2 * (pixel - area.center()).array() /
                                  Eigen::Array2d(area.width(), area.height());
  std::vector<Eigen::Array2d> values = {Eigen::Array2d::Ones(), position};
  for (int n = 1; n < degree; ++n)
    values.push_back(((2 * n + 1) * position * values[n] - n * values[n - 1]) /
                     (n + 1));
  Eigen::VectorXd products(NumPolynomials(degree));
  int k = 0;
  for (int sum = 0; sum <= degree; ++sum)
    for (int j = 0; j <= sum; ++j)
      products[k++] = values[sum - j].x() * values[j].y();
  return products;
}

}  // namespace raygrid
