#ifndef RAYGRID_ADJUSTMENT_NORMAL_EQUATIONS_H
#define RAYGRID_ADJUSTMENT_NORMAL_EQUATIONS_H

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "adjustment/gaussian_prior.h"
#include "adjustment/reprojection_error.h"

namespace raygrid {

/// A step of all parameters.
struct AdjustmentStep {
  std::vector<Eigen::VectorXd> cameras;  ///< none if they are fixed
  std::vector<Eigen::Matrix<double, 6, 1>> camera_poses;  ///< but the first's
  Eigen::VectorXd points;  ///< three numbers a point
  std::vector<Eigen::Matrix<double, 6, 1>> poses;
};

/// Random parameters that scatter as the adjusted ones do.
struct CovarianceSamples {
  std::vector<Eigen::MatrixXd> cameras;  ///< a column a sample
  Eigen::MatrixXd camera_poses;          ///< 6 rows each, but the first's
  Eigen::MatrixXd points;                ///< likewise
};

/// The Gauss-Newton equations H x = -g of bundle adjustment, in the blocks
///   [ A   W ] [ cameras, their poses in the rig, and kept group ]
///   [ W^T V ] [ eliminated group                                ]
/// The groups are rig poses (6 numbers each) and points (3 each). A residual
/// belongs to one pose and one point, so V is block-diagonal for either; the
/// larger group is eliminated (Schur complement) and a dense system is left.
class NormalEquations {
 public:
  struct Sizes {
    std::vector<int> num_camera_parameters;  ///< of each camera
    int num_points = 0, num_poses = 0;
    /// These get no equations; cameras are fixed with their poses in the rig.
    bool fix_cameras = false, fix_points = false;
  };
  static Sizes SizesOf(const AdjustmentState& state, bool fix_cameras,
                       bool fix_points);
  NormalEquations(const Sizes& sizes, int num_threads);

  void AddResiduals(const std::vector<LinearizedResidual>& residuals,
                    double huber_px);
  void AddPrior(const GaussianPrior& prior, const AdjustmentState& state);

  /// Solves with Marquardt's damping: lambda times H's diagonal is added.
  /// False if the system is not positive definite.
  bool Solve(double lambda, AdjustmentStep* step) const;

  /// Samples with the parameters' covariance in units of the residuals'
  /// variance: H^-1/2 z with z of random signs. Their mean quadratic form with
  /// a matrix estimates its trace with the covariance (Hutchinson, 1989), at a
  /// fraction of an inverse's cost. False if the system is singular.
  bool SampleCovariance(int num_samples, CovarianceSamples* samples) const;

 private:
  using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;
  void AddCameraPrior(const CameraPrior& prior, int first,
                      const Eigen::VectorXd& parameters);

  using BlockVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;

  // A - sum W V^-1 W^T, factored.
  struct Reduced {
    std::vector<Eigen::LLT<Block>> blocks;
    Eigen::LLT<Eigen::MatrixXd, Eigen::Lower> dense;
  };
  bool Reduce(double lambda, Reduced* reduced) const;

  // The parameters of the dense system, then the eliminated ones' for it.
  Eigen::MatrixXd Eliminated(const Reduced& reduced,
                             const Eigen::MatrixXd& dense) const;

  Sizes sizes_;
  int num_threads_;
  std::vector<int> first_parameter_;  // of each camera; and their end
  int num_camera_;                    // so many, and their poses in the rig
  bool eliminate_points_;             // or else the poses
  int block_size_;
  Eigen::MatrixXd a_;  // lower triangle
  Eigen::VectorXd gradient_;
  std::vector<Block> v_;
  std::vector<BlockVector> block_gradient_;
  std::vector<Eigen::MatrixXd> w_;
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_NORMAL_EQUATIONS_H
