#ifndef RAYGRID_ADJUSTMENT_DENSE_EQUATIONS_H
#define RAYGRID_ADJUSTMENT_DENSE_EQUATIONS_H

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "adjustment/normal_equations.h"
#include "adjustment/static_deformation.h"

namespace raygrid {

/// The normal equations in block form
///   [ A   W ] [ cameras, camera_from_rig, and kept group ]
///   [ W^T V ] [ eliminated group                         ]
/// The groups are rig poses (6 parameters each, and deformation) and points (3
/// each). A residual depends on one pose and one point, so V is block-diagonal
/// for either group; the larger one is eliminated, and the Schur complement is
/// factored. W is sparse if features of a point, or a pose, are near few
/// control points.
class DenseEquations : public NormalEquations {
 public:
  /// modes: deformation modes of the boards.
  DenseEquations(const ParameterLayout& layout,
                 const std::vector<ViewJacobian>& jacobians,
                 const DeformationModes& modes, const PriorEquations& prior,
                 int num_threads);

  bool Solve(double lambda, AdjustmentStep* step) const override;
  bool SolveFor(double lambda, const Eigen::MatrixXd& right,
                Eigen::MatrixXd* solution) const override;
  int MaxNumRightSides() const override { return 64; }

 private:
  // Right-hand sides or solutions: kept and eliminated parameters.
  struct Columns {
    Eigen::MatrixXd kept, eliminated;
  };
  // The rows of W that are not zero in successive blocks.
  struct Coupling {
    int first_block, num_blocks;
    std::vector<int> rows;  // ascending
    Eigen::MatrixXd w;      // these rows, blocks side by side
  };
  // The Schur complement A - sum W V^-1 W^T, factored.
  struct Reduced {
    std::vector<Eigen::LLT<PoseMatrix>> blocks;
    Eigen::LLT<Eigen::MatrixXd, Eigen::Lower> dense;
  };
  // Adds the products of a view's Jacobian. Static deformation is included only
  // if the points are fixed.
  void AddJacobian(const ViewJacobian& jacobian, const DeformationModes& modes);
  // Adds static deformation by the chain rule from the points
  // (StaticDeformation).
  void AddDeformation(const StaticDeformation& moves);
  void AddPrior(const PriorEquations& prior);
  // Moves W to couplings_. Successive blocks are combined if this saves
  // operations.
  void CompressCouplings();
  bool Reduce(double lambda, Reduced* reduced) const;
  // Returns the index of the first pose in its group, kept or eliminated.
  int FirstPose() const { return eliminate_points_ ? layout_.first_point : 0; }
  // Returns the number of parameters before the kept poses in the layout.
  int NumCommon() const {
    return eliminate_points_ ? layout_.first_point : layout_.size;
  }
  // Returns the last Schur complement if it has this damping, else null.
  const Reduced* ReducedFor(double lambda) const;
  Columns Solution(const Reduced& reduced, Columns right) const;

  ParameterLayout layout_;
  int num_threads_;
  bool eliminate_points_;  // false: poses are eliminated
  int block_size_;
  Eigen::MatrixXd a_;  // lower triangle
  std::vector<PoseMatrix> v_;
  Eigen::MatrixXd w_;  // blocks side by side; empty after construction
  std::vector<Coupling> couplings_;
  Columns gradient_;
  mutable double last_lambda_ = -1;
  mutable Reduced last_;
};

/// Returns the dimension of the dense Schur complement.
int NumDenseUnknowns(const ParameterLayout& layout);

/// Returns whether a problem of this size is solved faster than by
/// LargeEquations, given the operation count of their last solution; 0 if none.
bool DenseIsFaster(const ParameterLayout& layout, double large_operations);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_DENSE_EQUATIONS_H
