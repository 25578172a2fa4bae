#include "adjustment/gaussian_prior.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace raygrid {

void PriorGroup::Unpenalize(const UnpenalizedDirections& added) {
  unpenalized_ = added;
  full_rank_ = rank;
  ApplyRelativePrecisions(added.relative_precisions + added.precision_floor);
}

void PriorGroup::SetPrecision(double new_weight, double residual_variance) {
  weight = new_weight;
  if (unpenalized_.directions.cols() == 0 ||
      unpenalized_.precision_floor.isZero(0))
    return;
  ApplyRelativePrecisions(unpenalized_.relative_precisions +
                          unpenalized_.precision_floor *
                              (residual_variance / weight));
}

void PriorGroup::ApplyRelativePrecisions(
    const Eigen::VectorXd& relative_precisions) {
  // Marginalizing the coefficients of the directions turns the precision K into
  // K - K D0 (D0^T K D0 + holds)^-1 D0^T K. This defines D = D0 L^-T, where L
  // L^T is the matrix in parentheses.
  const Eigen::MatrixXd& directions = unpenalized_.directions;
  Eigen::MatrixXd square = directions.transpose() * precision * directions;
  square.diagonal() += relative_precisions;
  // Regularization, since the parameters of a model may be nearly dependent.
  constexpr double kRidge = 1e-10;
  square.diagonal() *= 1 + kRidge;
  const Eigen::LLT<Eigen::MatrixXd> root(square);
  free = root.matrixL().solve(directions.transpose()).transpose();
  // Rotates the directions so that D^T K D is diagonal.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen_solver(
      free.transpose() * precision * free);
  free = free * eigen_solver.eigenvectors();
  const double removed_fraction = 1 - kUnpenalizedScale * kUnpenalizedScale;
  unpenalized = std::sqrt(removed_fraction) * (precision * free);
  // (I - m K d d^T) b has the covariance K - (2 m - m^2 d^T K d) K d d^T K.
  rank = full_rank_;
  for (Eigen::Index k = 0; k < free.cols(); ++k) {
    constexpr double kMinUnpenalizedFraction = 0.5;
    const double g = std::min(eigen_solver.eigenvalues()[k], 1.0);
    free.col(k) *=
        std::sqrt(removed_fraction) / (1 + std::sqrt(1 - removed_fraction * g));
    rank -= g > kMinUnpenalizedFraction;
  }
}

Eigen::VectorXd ProjectOutUnpenalized(const Eigen::MatrixXd& free,
                                      const Eigen::MatrixXd& unpenalized,
                                      const Eigen::VectorXd& random) {
  if (free.cols() == 0) return random;
  return random - unpenalized * (free.transpose() * random);
}

double CameraPrior::Cost(const Eigen::VectorXd& parameters) const {
  const Eigen::VectorXd difference = parameters - mean;
  double cost = 0;
  for (const PriorGroup& group : groups)
    cost += group.weight / 2 * group.SquaredDistance(difference);
  return cost +
         orientation_precision / 2 * OrientationError(parameters).squaredNorm();
}

Eigen::VectorXd CameraPrior::OrientationError(
    const Eigen::VectorXd& parameters) const {
  if (orientation.cols() == 0) return Eigen::VectorXd(0);
  const Eigen::VectorXd eigen_solver =
      orientation.transpose() * (parameters - mean);
  if (orientation_difference.size() == 0) return eigen_solver;
  return eigen_solver - orientation_difference;
}

}  // namespace raygrid
