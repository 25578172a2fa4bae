#ifndef RAYGRID_ADJUSTMENT_PRECISION_ROOT_H
#define RAYGRID_ADJUSTMENT_PRECISION_ROOT_H

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <random>
#include <vector>

namespace raygrid {

/// A root B of a precision matrix, K = B B^T; rows of B are zero for parameters
/// that K does not involve.
class PrecisionRoot {
 public:
  explicit PrecisionRoot(const Eigen::SparseMatrix<double>& precision);

  /// Returns the number of columns of B.
  Eigen::Index size() const {
    return static_cast<Eigen::Index>(parameters_.size());
  }

  /// Returns B own, restricted to the first num_parameters parameters.
  Eigen::VectorXd Times(const Eigen::VectorXd& own,
                        Eigen::Index num_parameters) const;

 private:
  std::vector<int> parameters_;
  Eigen::SparseMatrix<double> root_;
};

/// Draws random signs (Rademacher): a vector with identity covariance.
Eigen::VectorXd RandomSigns(Eigen::Index size, std::mt19937* random_bits);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_PRECISION_ROOT_H
