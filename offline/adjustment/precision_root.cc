#include "adjustment/precision_root.h"

#include <Eigen/SparseCholesky>

namespace raygrid {

PrecisionRoot::PrecisionRoot(const Eigen::SparseMatrix<double>& precision) {
  std::vector<int> index(precision.cols(), -1);
  for (int k = 0; k < precision.cols(); ++k) {
    if (precision.coeff(k, k) == 0) continue;
    index[k] = static_cast<int>(parameters_.size());
    parameters_.push_back(k);
  }
  std::vector<Eigen::Triplet<double>> own;
  for (int k = 0; k < precision.outerSize(); ++k)
    for (Eigen::SparseMatrix<double>::InnerIterator it(precision, k); it; ++it)
      if (index[it.row()] >= 0 && index[it.col()] >= 0)
        own.emplace_back(index[it.row()], index[it.col()], it.value());
  Eigen::SparseMatrix<double> matrix(size(), size());
  matrix.setFromTriplets(own.begin(), own.end());
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> cholesky(matrix);
  root_ = cholesky.permutationPinv() *
          Eigen::SparseMatrix<double>(cholesky.matrixL());
}

Eigen::VectorXd PrecisionRoot::Times(const Eigen::VectorXd& own,
                                     Eigen::Index num_parameters) const {
  const Eigen::VectorXd product = root_ * own;
  Eigen::VectorXd all = Eigen::VectorXd::Zero(num_parameters);
  for (size_t k = 0; k < parameters_.size(); ++k)
    all[parameters_[k]] = product[static_cast<Eigen::Index>(k)];
  return all;
}

Eigen::VectorXd RandomSigns(Eigen::Index size, std::mt19937* random_bits) {
  Eigen::VectorXd signs(size);
  for (Eigen::Index i = 0; i < size; ++i)
    signs[i] = (*random_bits)() & 1 ? 1 : -1;
  return signs;
}

}  // namespace raygrid
