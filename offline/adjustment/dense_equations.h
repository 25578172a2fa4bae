#ifndef RAYGRID_ADJUSTMENT_DENSE_EQUATIONS_H
#define RAYGRID_ADJUSTMENT_DENSE_EQUATIONS_H

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "adjustment/normal_equations.h"
#include "adjustment/shape_moves.h"

namespace raygrid {

/// The equations in the blocks
///   [ A   W ] [ cameras, their poses in the rig, and kept group ]
///   [ W^T V ] [ eliminated group                                ]
/// The groups are rig poses (6 numbers each, and flex) and points (3 each). A
/// residual belongs to one pose and one point, so V is block-diagonal for
/// either; the larger group is eliminated (Schur complement) and a dense system
/// is left.
class DenseEquations : public NormalEquations {
 public:
  /// modes: the ways in which boards may bend.
  DenseEquations(const ParameterLayout& layout,
                 const std::vector<ViewJacobian>& jacobians,
                 const FlexModes& modes, const PriorEquations& prior,
                 int num_threads);

  bool Solve(double lambda, AdjustmentStep* step) const override;
  bool SolveFor(double lambda, const Eigen::MatrixXd& right,
                Eigen::MatrixXd* solution) const override;
  int NumCheapSides() const override { return 64; }

 private:
  // Right sides or solutions, of the kept and of the eliminated parameters.
  struct Columns {
    Eigen::MatrixXd kept, eliminated;
  };
  // A - sum W V^-1 W^T, factored.
  struct Reduced {
    std::vector<Eigen::LLT<PoseMatrix>> blocks;
    Eigen::LLT<Eigen::MatrixXd, Eigen::Lower> dense;
  };
  // Adds nothing to bends that boards have in all views, unless points are
  // fixed.
  void AddJacobian(const ViewJacobian& jacobian, const FlexModes& modes);
  // Gives bends the sums of their points, by ShapeMoves.
  void AddBends(const ShapeMoves& moves);
  void AddPrior(const PriorEquations& prior);
  bool Reduce(double lambda, Reduced* reduced) const;
  // The place of the first pose among the kept, or the eliminated.
  int FirstPose() const { return eliminate_points_ ? layout_.first_point : 0; }
  // Parameters before the kept poses, in the layout too.
  int NumCommon() const {
    return eliminate_points_ ? layout_.first_point : layout_.size;
  }
  // The last one made, if it has this damping.
  const Reduced* ReducedFor(double lambda) const;
  Columns Solution(const Reduced& reduced, Columns right) const;

  ParameterLayout layout_;
  int num_threads_;
  bool eliminate_points_;  // or else the poses
  int block_size_;
  Eigen::MatrixXd a_;  // lower triangle
  std::vector<PoseMatrix> v_;
  Eigen::MatrixXd w_;  // the blocks' columns side by side
  Columns gradient_;
  mutable double last_lambda_ = -1;
  mutable Reduced last_;
};

/// Unknowns of the dense system.
int NumDenseUnknowns(const ParameterLayout& layout);

/// Whether a problem of this size is solved faster than by LargeEquations,
/// whose last solution took so many operations; 0 if there was none.
bool DenseIsFaster(const ParameterLayout& layout, double large_operations);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_DENSE_EQUATIONS_H
