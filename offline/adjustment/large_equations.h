#ifndef RAYGRID_ADJUSTMENT_LARGE_EQUATIONS_H
#define RAYGRID_ADJUSTMENT_LARGE_EQUATIONS_H

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "adjustment/coarse_basis.h"
#include "adjustment/grid_transfer.h"
#include "adjustment/node_frames.h"
#include "adjustment/normal_equations.h"
#include "adjustment/residual_product.h"
#include "adjustment/shape_moves.h"

namespace raygrid {

/// The equations for many parameters, of which no matrix is formed. Rig poses
/// are eliminated; what is left,
///   S = A - sum W V^-1 W^T
/// over cameras, their poses in the rig and points, is applied residual by
/// residual within conjugate gradients. Their preconditioner adds up
///   - the inverses of the blocks of A of each node and each point, and of
///     each node of ever coarser grids: a multilevel preconditioner (Bramble,
///     Pasciak, Xu, "Parallel multilevel preconditioners", 1990), which
///     smoothness priors need. Those of a non-central grid have axes of their
///     own (NodeFrames());
///   - the inverse of S itself on the coarsest grid, with the points' bends of
///     second order: there lie the directions that poses can make up for, such
///     as focal lengths.
class LargeEquations : public NormalEquations {
 public:
  class Memory;

  /// Solutions stop at an error of about tolerance times their size. What
  /// *memory has of equations of this layout before is used as long as it
  /// serves; H's diagonal, for the damping, likewise.
  LargeEquations(const ParameterLayout& layout,
                 std::vector<ViewJacobian> jacobians,
                 const PriorEquations& prior, const AdjustmentState& state,
                 double tolerance, int num_threads,
                 std::shared_ptr<Memory> memory);

  bool Solve(double lambda, AdjustmentStep* step) const override;
  bool SolveFor(double lambda, const Eigen::MatrixXd& right,
                Eigen::MatrixXd* solution) const override;
  bool SolveWithRest(double lambda, const Eigen::MatrixXd& right,
                     Eigen::MatrixXd* solution,
                     Eigen::MatrixXd* rest) const override;
  int NumCheapSides() const override { return 4; }

 private:
  struct PoseBlock {
    std::vector<int> views;
    PoseMatrix v;
    PoseVector gradient;
  };
  // S with damping.
  struct System {
    double lambda = 0;
    Eigen::VectorXd damping;
    std::vector<Eigen::LLT<PoseMatrix>> poses;
  };
  // Blocks of the inverse, of a grid's nodes.
  struct Level {
    GridTransfer transfer;
    Eigen::MatrixXd inverse;  // per_node columns a node
  };
  struct CameraLevels {
    int first = 0;
    Eigen::MatrixXd inverse;
    std::vector<Level> levels;
  };
  struct Preconditioner {
    std::vector<CameraLevels> cameras;
    NodeFrames frames;       // that the cameras' blocks are in
    Eigen::MatrixXd points;  // three columns a point
    CoarseBasis basis;
    Eigen::LLT<Eigen::MatrixXd> coarse;
  };

  int NumChunks() const;
  int ChunkBegin(int chunk) const;
  // The sum of what body(pose, &sum) adds over ShapeMoves::moved().
  template <int kNum, typename Body>
  Columns<kNum> SumOverPoses(const Body& body) const;

  void AccumulatePoses();
  Eigen::SparseMatrix<double> LocalMatrix() const;

  bool MakeSystem(double lambda, System* system) const;
  template <int kNum>
  Columns<kNum> Apply(const System& system, const Columns<kNum>& x) const;
  Eigen::MatrixXd CoarseMatrix(const System& system,
                               const Preconditioner& preconditioner) const;
  bool MakePreconditioner(const System& system,
                          Preconditioner* preconditioner) const;
  // a: in the nodes' frames.
  CameraLevels LevelsOf(int camera, const Eigen::SparseMatrix<double>& a) const;
  template <int kNum>
  Columns<kNum> Precondition(const Preconditioner& preconditioner,
                             const Columns<kNum>& residual) const;
  // Solves by conjugate gradients, for several sides at once, from *x or from
  // zero. *side becomes what is left of it.
  template <int kNum>
  bool ConjugateGradients(const System& system, bool is_started,
                          Columns<kNum>* side, Columns<kNum>* x) const;
  // W y of a pose's y, added to *sum; W^T x of a pose. Over
  // ShapeMoves::moved().
  void AddByPose(int pose, const PoseVector& y, Eigen::VectorXd* sum) const;
  PoseVector OfPose(int pose, const Eigen::VectorXd& x) const;
  // W V^-1 y, over the layout.
  Eigen::VectorXd Eliminated(const System& system,
                             const Eigen::VectorXd& poses) const;
  // V^-1 (poses - W^T x)
  Eigen::VectorXd PosesBehind(const System& system, const Eigen::VectorXd& x,
                              Eigen::VectorXd poses) const;
  // Solves with a preconditioner that serves, from *x or from zero. *sides
  // become what is left of them.
  bool SolveSystem(const System& system, bool is_started,
                   Eigen::MatrixXd* sides, Eigen::MatrixXd* x) const;
  template <int kNum>
  bool SolveColumns(const System& system, bool is_started, Eigen::Index first,
                    Eigen::MatrixXd* sides, Eigen::MatrixXd* x) const;
  // From the last solution or from zero; arguments as of SolveWithRest().
  bool SolveAll(double lambda, bool is_started, const Eigen::MatrixXd& right,
                Eigen::MatrixXd* solution, Eigen::MatrixXd* rest) const;

  ParameterLayout layout_;
  ShapeMoves moves_;
  std::vector<ViewJacobian> jacobians_;
  PriorEquations prior_;
  std::vector<Eigen::Vector3d> points_;
  NodeFrames frames_;
  double tolerance_;
  int num_threads_;
  std::vector<GridShape> shapes_;
  std::vector<PoseBlock> poses_;
  Eigen::VectorXd gradient_;
  std::shared_ptr<Memory> memory_;
};

/// The memory of equations: all that later ones can use of them.
class LargeEquations::Memory {
 public:
  /// Iterations of conjugate gradients in the last solution from nothing.
  int last_iterations() const { return last_iterations_; }

 private:
  friend class LargeEquations;
  Eigen::VectorXd diagonal;           // of H without the prior
  Eigen::SparseMatrix<double> local;  // LocalMatrix() of the equations at hand
  std::unique_ptr<Preconditioner> preconditioner;
  int iterations_when_new = 0, last_iterations_ = 0;
  Eigen::MatrixXd last_solution;  // of SolveWithRest()
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_LARGE_EQUATIONS_H
