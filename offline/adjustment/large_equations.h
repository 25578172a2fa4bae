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
#include "adjustment/static_deformation.h"

namespace raygrid {

/// Normal equations of large problems; no matrix is formed. Rig poses are
/// eliminated, and the Schur complement S = A - sum W V^-1 W^T over cameras,
/// camera_from_rig and points is applied residual by residual in conjugate
/// gradients. The preconditioner is the sum of
///   - the inverse diagonal blocks of A for control points and target points,
///     and for control points of ever coarser grids: a multilevel
///     preconditioner
///     (Bramble, Pasciak, Xu, "Parallel multilevel preconditioners", 1990),
///     which smoothness priors require; in local axes for non-central grids;
///   - the inverse of S on the coarsest grid, with deformation modes of second
///     order: it covers the directions that poses nearly compensate, such as
///     focal lengths.
class LargeEquations : public NormalEquations {
 public:
  class Workspace;

  /// Solves with a relative error of about `tolerance`. Reuses from *memory the
  /// preconditioner that earlier equations of this layout computed, as long as
  /// convergence is fast, and the diagonal of H for damping.
  LargeEquations(const ParameterLayout& layout,
                 std::vector<ViewJacobian> jacobians,
                 const PriorEquations& prior, const AdjustmentState& state,
                 double tolerance, int num_threads,
                 std::shared_ptr<Workspace> memory);

  bool Solve(double lambda, AdjustmentStep* step) const override;
  bool SolveFor(double lambda, const Eigen::MatrixXd& right,
                Eigen::MatrixXd* solution) const override;
  bool SolveWithResidual(double lambda, const Eigen::MatrixXd& right,
                         Eigen::MatrixXd* solution,
                         Eigen::MatrixXd* rest) const override;
  int MaxNumRightSides() const override { return 4; }

 private:
  struct PoseBlock {
    std::vector<int> views;
    PoseMatrix v;
    PoseVector gradient;
  };
  // The damped Schur complement.
  struct System {
    double lambda = 0;
    Eigen::VectorXd damping;
    std::vector<Eigen::LLT<PoseMatrix>> poses;
  };
  // Inverse blocks of the control points of one grid level.
  struct Level {
    GridTransfer transfer;
    Eigen::MatrixXd inverse;  // per_node columns per node
  };
  struct CameraMultigrid {
    int first = 0;
    Eigen::MatrixXd inverse;
    std::vector<Level> levels;
  };
  struct Preconditioner {
    std::vector<CameraMultigrid> cameras;
    NodeFrames frames;       // axes of the cameras' blocks
    Eigen::MatrixXd points;  // three columns per point
    CoarseBasis basis;
    Eigen::LLT<Eigen::MatrixXd> coarse;
  };

  int NumChunks() const;
  int ChunkBegin(int chunk) const;
  // Sums the contributions body(pose, &sum) over StaticDeformation::moved().
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
  // Returns the preconditioner levels of a camera; a: in local axes
  // (NodeFrames).
  CameraMultigrid MakeMultigridLevels(
      int camera, const Eigen::SparseMatrix<double>& a) const;
  template <int kNum>
  Columns<kNum> Precondition(const Preconditioner& preconditioner,
                             const Columns<kNum>& residual) const;
  // Solves by conjugate gradients for several right-hand sides, from *x or from
  // zero. *side becomes the final residual.
  template <int kNum>
  bool ConjugateGradients(const System& system, bool is_started,
                          Columns<kNum>* side, Columns<kNum>* x) const;
  // Adds W y of one pose to *sum; returns W^T x of a pose. Over
  // StaticDeformation::moved().
  void AddPoseProduct(int pose, const PoseVector& y,
                      Eigen::VectorXd* sum) const;
  PoseVector ComputePoseProduct(int pose, const Eigen::VectorXd& x) const;
  // Returns W V^-1 y, over the layout.
  Eigen::VectorXd EliminatePoses(const System& system,
                                 const Eigen::VectorXd& poses) const;
  // Returns V^-1 (poses - W^T x)
  Eigen::VectorXd BackSubstitutePoses(const System& system,
                                      const Eigen::VectorXd& x,
                                      Eigen::VectorXd poses) const;
  // Solves with a suitable preconditioner, from *x or from zero. *sides become
  // the final residuals.
  bool SolveSystem(const System& system, bool is_started,
                   Eigen::MatrixXd* sides, Eigen::MatrixXd* x) const;
  template <int kNum>
  bool SolveColumns(const System& system, bool is_started, Eigen::Index first,
                    Eigen::MatrixXd* sides, Eigen::MatrixXd* x) const;
  // Solves from the last solution or from zero; see SolveWithResidual().
  bool SolveAll(double lambda, bool is_started, const Eigen::MatrixXd& right,
                Eigen::MatrixXd* solution, Eigen::MatrixXd* rest) const;

  ParameterLayout layout_;
  StaticDeformation static_deformation_;
  std::vector<ViewJacobian> jacobians_;
  PriorEquations prior_;
  std::vector<Eigen::Vector3d> points_;
  NodeFrames frames_;
  double tolerance_;
  int num_threads_;
  std::vector<GridShape> shapes_;
  std::vector<PoseBlock> poses_;
  Eigen::VectorXd gradient_;
  std::shared_ptr<Workspace> workspace_;
};

/// State that later equations of the same layout can reuse.
class LargeEquations::Workspace {
 public:
  /// Returns the conjugate-gradient iterations of the last solution from zero.
  int last_iterations() const { return last_iterations_; }

 private:
  friend class LargeEquations;
  Eigen::VectorXd diagonal;           // diagonal of H without the prior
  Eigen::SparseMatrix<double> local;  // LocalMatrix() of the current equations
  std::unique_ptr<Preconditioner> preconditioner;
  int cold_start_iterations_ = 0, last_iterations_ = 0;
  Eigen::MatrixXd last_solution;  // result of SolveWithResidual()
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_LARGE_EQUATIONS_H
