#ifndef RAYGRID_ADJUSTMENT_NORMAL_EQUATIONS_H
#define RAYGRID_ADJUSTMENT_NORMAL_EQUATIONS_H

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "adjustment/gaussian_prior.h"
#include "adjustment/view_jacobian.h"

namespace raygrid {

/// A step of all parameters.
struct AdjustmentStep {
  std::vector<Eigen::VectorXd> cameras;  ///< none if they are fixed
  std::vector<Eigen::Matrix<double, 6, 1>> camera_poses;  ///< but the first's
  std::vector<Eigen::Matrix<double, 6, 1>> places;        ///< if not fixed
  Eigen::VectorXd points;  ///< three numbers a point
  std::vector<Eigen::Matrix<double, 6, 1>> poses;
  std::vector<FlexModes::Coefficients> flex;  ///< if boards bend
};

/// The parameters without equations; cameras are fixed with their poses in the
/// rig. Places of boards on bodies, and boards' shapes, are fixed where both
/// others are.
struct FixedParameters {
  bool cameras = false, points = false;
};

/// The places of parameters in a vector of them all: cameras, their poses in
/// the rig, boards' places on bodies, bends that boards have in all views,
/// points; then, beyond its size, the rig poses, each with the flex of the
/// board that stands there.
struct ParameterLayout {
  ParameterLayout(const AdjustmentState& state, const FixedParameters& fixed);

  std::vector<int> first_camera;  ///< of each, and their end; {0} if fixed
  int first_place = 0, first_shape = 0, first_point = 0, size = 0;
  int per_board = 0;   ///< bends of a board in all views
  int num_points = 0;  ///< 0 if they are fixed
  int num_poses = 0;   ///< of the rig
  int per_pose = 6;    ///< parameters of a pose and of the board's flex

  bool has_cameras() const { return first_camera.size() > 1; }
  int NumCameraParameters(int camera) const {
    return first_camera[camera + 1] - first_camera[camera];
  }
  /// The place of the pose of a camera but the first.
  int CameraPose(int camera) const {
    return first_camera.back() + 6 * (camera - 1);
  }
  bool has_places() const { return first_place < first_shape; }
  int Place(int place) const { return first_place + 6 * place; }
  bool has_shapes() const { return first_shape < first_point; }
  int Shape(int board) const { return first_shape + per_board * board; }
  int Point(int point) const { return first_point + 3 * point; }

  int Pose(int pose) const { return size + per_pose * pose; }
  int num_all() const { return Pose(num_poses); }

  /// A step out of its parts.
  AdjustmentStep Step(const Eigen::VectorXd& parameters,
                      const Eigen::VectorXd& poses) const;
};

/// The prior's share of the equations, in the layout: P.
struct PriorEquations {
  PriorEquations(const GaussianPrior& prior, const AdjustmentState& state,
                 const ParameterLayout& layout);

  /// P = precision + root root^T - freed freed^T, the latter of few columns.
  Eigen::SparseMatrix<double> precision;
  Eigen::MatrixXd root, freed;
  Eigen::MatrixXd free;  ///< as in PriorGroup
  Eigen::VectorXd gradient;
  FlexModes::Coefficients flex_precision;  ///< of each mode of each pose
  Eigen::MatrixXd flex_gradient;           ///< a column a pose

  /// P x, over the layout without the poses.
  Eigen::MatrixXd Times(const Eigen::MatrixXd& x) const {
    return precision * x + root * (root.transpose() * x) -
           freed * (freed.transpose() * x);
  }
};

/// A floor for the damping, so that a parameter that nothing depends on does
/// not make the system singular.
constexpr double kDampingFloor = 1e-9;

/// A pose's parameters and flex, and a block of H.
constexpr int kMaxPerPose = 6 + FlexModes::kMaxCount;
using PoseVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxPerPose, 1>;
using PoseMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0,
                                 kMaxPerPose, kMaxPerPose>;

/// The Gauss-Newton equations H x = -g of bundle adjustment.
class NormalEquations {
 public:
  virtual ~NormalEquations() = default;

  /// Solves with Marquardt's damping: lambda times H's diagonal is added.
  /// False if the system is not positive definite.
  virtual bool Solve(double lambda, AdjustmentStep* step) const = 0;

  /// H x = right, damped likewise, for several right sides: over all
  /// parameters, or over those before the poses, which stand for sides that are
  /// zero behind them. *solution is over the same.
  virtual bool SolveFor(double lambda, const Eigen::MatrixXd& right,
                        Eigen::MatrixXd* solution) const = 0;
  /// SolveFor(), which also tells what is left: *rest = right - H x. It is zero
  /// unless solutions are reached by iterations.
  virtual bool SolveWithRest(double lambda, const Eigen::MatrixXd& right,
                             Eigen::MatrixXd* solution,
                             Eigen::MatrixXd* rest) const {
    rest->setZero(right.rows(), right.cols());
    return SolveFor(lambda, right, solution);
  }
  /// How many right sides can be afforded for each Solve().
  virtual int NumCheapSides() const = 0;
};

/// Builds equations around one state after the other: DenseEquations for small
/// problems and where the cameras are fixed, or else LargeEquations.
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
  std::shared_ptr<void> memory_;  // of LargeEquations
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_NORMAL_EQUATIONS_H
