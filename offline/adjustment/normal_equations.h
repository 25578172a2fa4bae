#ifndef RAYGRID_ADJUSTMENT_NORMAL_EQUATIONS_H
#define RAYGRID_ADJUSTMENT_NORMAL_EQUATIONS_H

#include <Eigen/Core>
#include <vector>

#include "adjustment/gaussian_prior.h"
#include "adjustment/reprojection_error.h"

namespace raygrid {

/// A step of all parameters.
struct AdjustmentStep {
  Eigen::VectorXd camera;
  Eigen::VectorXd points;  ///< three numbers a point
  std::vector<Eigen::Matrix<double, 6, 1>> poses;
};

/// The Gauss-Newton equations H x = -g of bundle adjustment, in the blocks
///   [ A   W ] [ camera and points ]
///   [ W^T V ] [ poses             ]
/// V is block-diagonal, for a residual belongs to one view, so the poses are
/// eliminated (Schur complement) and a dense system over camera and points is
/// left.
class NormalEquations {
 public:
  /// fix_camera, fix_points: those parameters get no equations.
  NormalEquations(int num_camera_parameters, int num_points, int num_views,
                  bool fix_camera, bool fix_points, int num_threads);

  void AddResiduals(const std::vector<LinearizedResidual>& residuals,
                    double huber_px);
  void AddPrior(const GaussianPrior& prior, const AdjustmentState& state);

  /// Solves with Marquardt's damping: lambda times H's diagonal is added.
  /// False if the system is not positive definite.
  bool Solve(double lambda, AdjustmentStep* step) const;

  /// Columns that scatter with the covariance of the adjusted camera parameters,
  /// then points, in units of the residuals' variance: with z of random signs
  /// and L L^T the reduced system, L^-T z. Their mean quadratic form with a
  /// matrix estimates its trace with the covariance (Hutchinson, 1989), at a
  /// fraction of an inverse's cost. False if the system is singular.
  bool CovarianceSamples(int num_samples, Eigen::MatrixXd* samples) const;

  int num_camera() const { return num_camera_; }

 private:
  using Matrix6d = Eigen::Matrix<double, 6, 6>;

  // A - sum W V^-1 W^T with damping; *weighted = W L^-T of each V = L L^T.
  bool Reduce(double lambda, Eigen::MatrixXd* reduced, Eigen::VectorXd* right,
              Eigen::MatrixXd* weighted,
              std::vector<Eigen::LLT<Matrix6d>>* factors) const;

  int num_camera_, num_point_parameters_;
  bool fix_camera_, fix_points_;
  int num_threads_;
  Eigen::MatrixXd a_;  // lower triangle
  Eigen::VectorXd gradient_;
  std::vector<Matrix6d> v_;
  std::vector<Eigen::Matrix<double, 6, 1>> pose_gradient_;
  std::vector<Eigen::MatrixXd> w_;
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_NORMAL_EQUATIONS_H
