#ifndef RAYGRID_ADJUSTMENT_NORMAL_EQUATIONS_H
#define RAYGRID_ADJUSTMENT_NORMAL_EQUATIONS_H

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "adjustment/gaussian_prior.h"
#include "adjustment/view_jacobian.h"

namespace raygrid {

/// A Gauss-Newton step of all parameters.
struct AdjustmentStep {
  std::vector<Eigen::VectorXd> cameras;  ///< empty if they are fixed
  std::vector<Eigen::Matrix<double, 6, 1>> camera_poses;  ///< without the first
                                                          ///< camera's
  std::vector<Eigen::Matrix<double, 6, 1>> places;        ///< empty if fixed
  Eigen::VectorXd points;  ///< three coordinates per point
  std::vector<Eigen::Matrix<double, 6, 1>> poses;
  std::vector<DeformationModes::Coefficients>
      flex;  ///< if deformation is estimated
};

/// Parameters that are not optimized; fixed cameras imply a fixed
/// camera_from_rig. target_from_board and static deformation are fixed if
/// cameras and points are.
struct FixedParameters {
  bool cameras = false, points = false;
};

/// Indices of parameters in a vector: cameras, camera_from_rig,
/// target_from_board, static deformation, points; after the first `size`
/// elements, rig_from_pattern, each with the per-view deformation of its board.
struct ParameterLayout {
  ParameterLayout(const AdjustmentState& state, const FixedParameters& fixed);

  std::vector<int> first_camera;  ///< start indices and end; {0} if fixed
  int first_board_pose = 0, first_shape = 0, first_point = 0, size = 0;
  int per_board = 0;   ///< static modes per board
  int num_points = 0;  ///< 0 if they are fixed
  int num_poses = 0;   ///< rig_from_pattern
  int per_pose = 6;    ///< pose and its deformation

  bool has_cameras() const { return first_camera.size() > 1; }
  int NumCameraParameters(int camera) const {
    return first_camera[camera + 1] - first_camera[camera];
  }
  /// Returns the index of camera_from_rig of a camera other than the first.
  int CameraPose(int camera) const {
    return first_camera.back() + 6 * (camera - 1);
  }
  bool has_board_poses() const { return first_board_pose < first_shape; }
  int Place(int place) const { return first_board_pose + 6 * place; }
  bool has_shapes() const { return first_shape < first_point; }
  int Shape(int board) const { return first_shape + per_board * board; }
  int Point(int point) const { return first_point + 3 * point; }

  int Pose(int pose) const { return size + per_pose * pose; }
  int num_all() const { return Pose(num_poses); }

  /// Assembles a step from the vectors of common parameters and of poses.
  AdjustmentStep UnpackStep(const Eigen::VectorXd& parameters,
                            const Eigen::VectorXd& poses) const;
};

/// The prior's contribution to the normal equations, in the layout: P.
struct PriorEquations {
  PriorEquations(const GaussianPrior& prior, const AdjustmentState& state,
                 const ParameterLayout& layout);

  /// P = precision + root root^T - freed freed^T, the latter of low rank.
  Eigen::SparseMatrix<double> precision;
  Eigen::MatrixXd root, unpenalized;
  Eigen::MatrixXd free;  ///< see PriorGroup
  Eigen::VectorXd gradient;
  DeformationModes::Coefficients
      deformation_precision;             ///< by mode, for each pose
  Eigen::MatrixXd deformation_gradient;  ///< one column per pose

  /// Returns P x, over the layout without the poses.
  Eigen::MatrixXd Times(const Eigen::MatrixXd& x) const {
    return precision * x + root * (root.transpose() * x) -
           unpenalized * (unpenalized.transpose() * x);
  }
};

/// Lower limit of the damping, so that an unconstrained parameter does not make
/// the system singular.
constexpr double kDampingFloor = 1e-9;

/// Maximum number of parameters of a pose with its deformation.
constexpr int kMaxPerPose = 6 + DeformationModes::kMaxCount;
using PoseVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxPerPose, 1>;
using PoseMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0,
                                 kMaxPerPose, kMaxPerPose>;

/// The Gauss-Newton equations H x = -g of bundle adjustment.
class NormalEquations {
 public:
  virtual ~NormalEquations() = default;

  /// Solves with Marquardt damping: lambda times the diagonal of H is added.
  /// Returns false if the system is not positive definite.
  virtual bool Solve(double lambda, AdjustmentStep* step) const = 0;

  /// Solves H x = right with the same damping for several right-hand sides:
  /// over all parameters, or over the parameters before the poses, with zeros
  /// for the poses. *solution has the same rows.
  virtual bool SolveFor(double lambda, const Eigen::MatrixXd& right,
                        Eigen::MatrixXd* solution) const = 0;
  /// SolveFor() that also returns the residual of the solution, *rest = right -
  /// H x, which is zero for direct solvers.
  virtual bool SolveWithResidual(double lambda, const Eigen::MatrixXd& right,
                                 Eigen::MatrixXd* solution,
                                 Eigen::MatrixXd* rest) const {
    rest->setZero(right.rows(), right.cols());
    return SolveFor(lambda, right, solution);
  }
  /// Returns the number of right-hand sides that cost about one Solve().
  virtual int MaxNumRightSides() const = 0;
};

/// Builds the normal equations of successive states: DenseEquations for small
/// problems and fixed cameras, otherwise LargeEquations.
class EquationsBuilder {
 public:
  EquationsBuilder(const std::vector<View>& views, double huber_px,
                   int num_threads)
      : views_(views), huber_px_(huber_px), num_threads_(num_threads) {}

  std::unique_ptr<NormalEquations> Build(const GaussianPrior& prior,
                                         const FixedParameters& fixed,
                                         const AdjustmentState& state);

 private:
  const std::vector<View>& views_;
  double huber_px_;
  int num_threads_;
  std::shared_ptr<void> workspace_;  // reused state of LargeEquations
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_NORMAL_EQUATIONS_H
