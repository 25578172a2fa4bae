#include "fleet/principal_directions.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace raygrid {

PrincipalDirections ComputeDirections(const Eigen::MatrixXd& rows,
                                      const std::vector<bool>& is_usual) {
  const auto count =
      static_cast<double>(std::count(is_usual.begin(), is_usual.end(), true));
  Eigen::MatrixXd usual = rows;
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    if (!is_usual[i]) usual.row(i).setZero();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      usual.transpose() * usual / (count - 1));
  PrincipalDirections all{solver.eigenvectors().rowwise().reverse(),
                          solver.eigenvalues().reverse()};
  // Keeps the directions that explain nearly all of the variance, at most a
  // quarter of the number of units.
  constexpr double kMinVarianceFraction = 0.999;
  const double total = all.variances.sum();
  const auto most = std::min<Eigen::Index>(
      all.variances.size(), static_cast<Eigen::Index>(count / 4));
  Eigen::Index size = 1;
  while (size < most &&
         all.variances.head(size).sum() < kMinVarianceFraction * total)
    ++size;
  return {all.axes.leftCols(size), all.variances.head(size)};
}

}  // namespace raygrid
