#ifndef RAYGRID_EVALUATION_CROSS_FIT_H
#define RAYGRID_EVALUATION_CROSS_FIT_H

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <array>
#include <vector>

namespace raygrid {

/// Errors that units, such as views or places, have of their own: those of a
/// unit's features are X c, where a unit has its coefficients c. An error has
/// two coordinates, one after the other.
struct LinearCause {
  int num_units = 0;
  std::vector<int> unit;    ///< of each feature; -1: of none
  std::vector<int> half;    ///< 0 or 1, of each feature
  Eigen::MatrixXd columns;  ///< X, transposed: k x 2 features
};

/// Fits a cause to one half of the features, and predicts with it. Coefficients
/// scatter around zero by a deviation that all units together tell (the largest
/// marginal likelihood): of noise alone it is zero, and so is the prediction.
class CrossFit {
 public:
  explicit CrossFit(LinearCause cause);

  /// The errors of all features as half of them tell the coefficients.
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

  LinearCause cause_;
  // For each half: eigenvectors of the units' normal equations side by side,
  // and eigenvalues, a column a unit.
  std::array<Eigen::MatrixXd, 2> vectors_, values_;
};

/// By how much predictions of the other half lower the squared errors of each
/// unit; negative, if they raise them. Each half of the coefficients has errors
/// of its own, and its predictions.
std::vector<double> ExplainedSquares(
    const CrossFit& fit, const std::array<Eigen::VectorXd, 2>& errors,
    const std::array<Eigen::VectorXd, 2>& predicted);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_CROSS_FIT_H
