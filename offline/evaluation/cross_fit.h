#ifndef RAYGRID_EVALUATION_CROSS_FIT_H
#define RAYGRID_EVALUATION_CROSS_FIT_H

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <array>
#include <vector>

namespace raygrid {

/// Linear model of errors specific to units, such as views or image regions:
/// the errors of a unit's features are X c, with coefficients c for each unit.
/// An error has two coordinates, one after the other.
struct LinearCauseModel {
  int num_units = 0;
  std::vector<int> unit;    ///< index of each feature's unit; -1: none
  std::vector<int> half;    ///< 0 or 1, per feature
  Eigen::MatrixXd columns;  ///< X, transposed: k x 2 features
};

/// Fits a cause to one half of the features, and predicts the other. The
/// zero-mean prior of the coefficients maximizes the marginal likelihood of all
/// units: for pure noise, its variance and the prediction are zero.
class CrossFit {
 public:
  explicit CrossFit(LinearCauseModel cause);

  /// Predicts the errors of all features from one half.
  Eigen::VectorXd Predict(int half, const Eigen::VectorXd& errors) const;

  int num_units() const { return cause_.num_units; }
  int unit(size_t feature) const { return cause_.unit[feature]; }
  int half(size_t feature) const { return cause_.half[feature]; }
  bool HasUnit(size_t feature) const { return cause_.unit[feature] >= 0; }

 private:
  using Solver = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

  Eigen::MatrixXd Products(int half, const Eigen::VectorXd& errors) const;
  Eigen::MatrixXd Shrink(int half, double squares, double count,
                         const Eigen::MatrixXd& products) const;

  LinearCauseModel cause_;
  // For each half: eigenvectors of the units' normal equations side by side,
  // and eigenvalues, one column per unit.
  std::array<Eigen::MatrixXd, 2> vectors_, values_;
};

/// Computes the reduction of each unit's squared errors by predicting each half
/// from the other; negative if the prediction increases them.
std::vector<double> ComputeExplainedSquares(
    const CrossFit& fit, const std::array<Eigen::VectorXd, 2>& errors,
    const std::array<Eigen::VectorXd, 2>& predicted);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_CROSS_FIT_H
