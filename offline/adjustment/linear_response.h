#ifndef RAYGRID_ADJUSTMENT_LINEAR_RESPONSE_H
#define RAYGRID_ADJUSTMENT_LINEAR_RESPONSE_H

#include <Eigen/Core>
#include <memory>
#include <random>
#include <vector>

#include "adjustment/bundle_adjustment.h"
#include "adjustment/normal_equations.h"
#include "adjustment/precision_root.h"
#include "adjustment/static_deformation.h"

namespace raygrid {

/// Errors of the residuals of each view, one column per observation. Errors of
/// parameters are ordered as in ParameterLayout.
using ViewErrors = std::vector<Eigen::Matrix2Xd>;

/// The linear response of an estimated state to errors of its observations and
/// of its prior mean: H x = J^T e + g, with H = J^T J + P.
class LinearResponse {
 public:
  /// Factors H up to a limit on the number of unknowns of DenseEquations;
  /// larger problems are solved iteratively to an error of 1 %.
  LinearResponse(const std::vector<View>& views, const GaussianPrior& prior,
                 const AdjustmentOptions& options, const AdjustmentState& state,
                 int max_exact_unknowns = 2500);

  bool IsExact() const { return is_exact_; }
  const ParameterLayout& layout() const { return layout_; }
  const PriorEquations& prior() const { return prior_; }
  const std::vector<ViewJacobian>& jacobians() const { return jacobians_; }

  /// Returns J^T e.
  Eigen::VectorXd Gradient(const ViewErrors& errors) const;
  /// Returns J x.
  ViewErrors ApplyJacobian(const Eigen::VectorXd& parameters) const;

  /// Draws white errors of variance 1.
  ViewErrors SampleNoise(std::mt19937* random_bits) const;
  /// Draws a gradient with covariance P, without the part due to deformation.
  Eigen::VectorXd SamplePrior(std::mt19937* random_bits) const;
  /// Draws a gradient whose covariance is the part of P due to deformation.
  Eigen::VectorXd SampleDeformationPrior(std::mt19937* random_bits) const;
  /// Returns the gradient of the prior.
  Eigen::VectorXd PriorGradient() const;

  /// Solves for several right-hand sides over all parameters, or the parameters
  /// before the poses. Returns false if H is not positive definite.
  bool Solve(const Eigen::MatrixXd& right, Eigen::MatrixXd* x) const {
    return equations_->SolveFor(0, right, x);
  }

 private:
  ParameterLayout layout_;
  PriorEquations prior_;
  StaticDeformation static_deformation_;
  std::vector<ViewJacobian> jacobians_;
  bool is_exact_;
  PrecisionRoot prior_root_;
  std::unique_ptr<NormalEquations> equations_;
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_LINEAR_RESPONSE_H
