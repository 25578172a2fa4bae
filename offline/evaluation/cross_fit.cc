#include "evaluation/cross_fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace raygrid {

CrossFit::CrossFit(LinearCauseModel cause) : cause_(std::move(cause)) {
  const Eigen::Index k = cause_.columns.rows();
  for (int half = 0; half < 2; ++half) {
    std::vector<Eigen::MatrixXd> products(cause_.num_units,
                                          Eigen::MatrixXd::Zero(k, k));
    for (size_t i = 0; i < cause_.unit.size(); ++i) {
      if (!HasUnit(i) || cause_.half[i] != half) continue;
      const auto x =
          cause_.columns.middleCols<2>(2 * static_cast<Eigen::Index>(i));
      products[cause_.unit[i]].noalias() += x.lazyProduct(x.transpose());
    }
    vectors_[half].resize(k, k * cause_.num_units);
    values_[half].resize(k, cause_.num_units);
    for (int u = 0; u < cause_.num_units; ++u) {
      const Solver solver(products[u]);
      vectors_[half].middleCols(u * k, k) = solver.eigenvectors();
      values_[half].col(u) = solver.eigenvalues().cwiseMax(0);
    }
  }
}

// Returns the products of the errors of a half with the columns, in the
// eigenvector basis.
Eigen::MatrixXd CrossFit::Products(int half,
                                   const Eigen::VectorXd& errors) const {
  const Eigen::Index k = cause_.columns.rows();
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(k, cause_.num_units);
  for (size_t i = 0; i < cause_.unit.size(); ++i) {
    if (!HasUnit(i) || cause_.half[i] != half) continue;
    const Eigen::Index at = 2 * static_cast<Eigen::Index>(i);
    products.col(cause_.unit[i]).noalias() +=
        cause_.columns.middleCols<2>(at).lazyProduct(errors.segment<2>(at));
  }
  for (int u = 0; u < cause_.num_units; ++u)
    products.col(u) =
        (vectors_[half].middleCols(u * k, k).transpose() * products.col(u))
            .eval();
  return products;
}

// Returns the coefficients in the eigenvector basis. The ratio of the prior
// variance to the noise variance maximizes the marginal likelihood; the noise
// variance has its maximum-likelihood value given this ratio.
Eigen::MatrixXd CrossFit::Shrink(int half, double squares, double count,
                                 const Eigen::MatrixXd& products) const {
  constexpr int kDoublings = 24;
  constexpr double kLeast = 1.0 / 64;
  const Eigen::ArrayXXd d = values_[half].array();
  const Eigen::ArrayXXd products_squared = products.array().square();
  const double largest = d.size() > 0 ? d.maxCoeff() : 0;
  double best_likelihood = 0, best_ratio = 0;  // values for zero coefficients
  for (int i = 0; largest > 0 && i < kDoublings; ++i) {
    const double ratio = std::ldexp(kLeast, i) / largest;  // squared
    const Eigen::ArrayXXd more = 1 + ratio * d;
    const double left = squares - (products_squared * (ratio / more)).sum();
    if (!(left > 0)) break;
    const double likelihood =
        -0.5 * (count * std::log(left / squares) + more.log().sum());
    if (likelihood <= best_likelihood) continue;
    best_likelihood = likelihood;
    best_ratio = ratio;
  }
  return (products.array() * (best_ratio / (1 + best_ratio * d))).matrix();
}

Eigen::VectorXd CrossFit::Predict(int half,
                                  const Eigen::VectorXd& errors) const {
  const Eigen::Index k = cause_.columns.rows();
  double squares = 0;
  int count = 0;
  for (size_t i = 0; i < cause_.unit.size(); ++i) {
    if (!HasUnit(i) || cause_.half[i] != half) continue;
    squares +=
        errors.segment<2>(2 * static_cast<Eigen::Index>(i)).squaredNorm();
    count += 2;
  }
  Eigen::VectorXd predicted = Eigen::VectorXd::Zero(errors.size());
  if (!(squares > 0)) return predicted;
  Eigen::MatrixXd coefficients =
      Shrink(half, squares, count, Products(half, errors));
  for (int u = 0; u < cause_.num_units; ++u)
    coefficients.col(u) =
        (vectors_[half].middleCols(u * k, k) * coefficients.col(u)).eval();
  for (size_t i = 0; i < cause_.unit.size(); ++i) {
    if (!HasUnit(i)) continue;
    const Eigen::Index at = 2 * static_cast<Eigen::Index>(i);
    predicted.segment<2>(at).noalias() =
        cause_.columns.middleCols<2>(at).transpose().lazyProduct(
            coefficients.col(cause_.unit[i]));
  }
  return predicted;
}

std::vector<double> ComputeExplainedSquares(
    const CrossFit& fit, const std::array<Eigen::VectorXd, 2>& errors,
    const std::array<Eigen::VectorXd, 2>& predicted) {
  std::vector<double> explained(fit.num_units(), 0);
  const auto count = static_cast<size_t>(errors[0].size() / 2);
  for (size_t i = 0; i < count; ++i) {
    if (!fit.HasUnit(i)) continue;
    const int predicting_half = 1 - fit.half(i);
    const Eigen::Index at = 2 * static_cast<Eigen::Index>(i);
    const Eigen::Vector2d error = errors[predicting_half].segment<2>(at);
    explained[fit.unit(i)] +=
        error.squaredNorm() -
        (error - predicted[predicting_half].segment<2>(at)).squaredNorm();
  }
  return explained;
}

}  // namespace raygrid
