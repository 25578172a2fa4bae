#ifndef RAYGRID_ADJUSTMENT_PRECISION_ROOT_H
#define RAYGRID_ADJUSTMENT_PRECISION_ROOT_H

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <random>
#include <vector>

namespace raygrid {

/// B with K = B B^T, of the parameters that a precision K is about; the others'
/// rows of K are zero.
class PrecisionRoot {
 public:
  explicit PrecisionRoot(const Eigen::SparseMatrix<double>& precision);

  /// Columns of B.
  Eigen::Index size() const {
    return static_cast<Eigen::Index>(parameters_.size());
  }

  /// B own, over the first num_parameters parameters.
  Eigen::VectorXd Times(const Eigen::VectorXd& own,
                        Eigen::Index num_parameters) const;

 private:
  std::vector<int> parameters_;
  Eigen::SparseMatrix<double> root_;
};

/// 1 or -1 each: the covariance is the identity.
Eigen::VectorXd RandomSigns(Eigen::Index size, std::mt19937* random_bits);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_PRECISION_ROOT_H
