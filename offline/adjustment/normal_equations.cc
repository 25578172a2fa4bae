#include "adjustment/normal_equations.h"

#include <cmath>

#include "adjustment/dense_equations.h"
#include "adjustment/large_equations.h"

namespace raygrid {
namespace {

int NumFree(const CameraPrior& prior) {
  int count = 0;
  for (const PriorGroup& group : prior.groups)
    count += static_cast<int>(group.free.cols());
  return count;
}

// Index of the camera's first column in the matrices.
struct FirstColumns {
  Eigen::Index root = 0, free = 0;
};

void AddGroup(const PriorGroup& group, int first, Eigen::Index first_free,
              const Eigen::VectorXd& difference,
              std::vector<Eigen::Triplet<double>>* precision,
              PriorEquations* equations) {
  auto gradient = equations->gradient.segment(first, difference.size());
  gradient += group.weight * (group.precision * difference);
  for (int k = 0; k < group.precision.outerSize(); ++k)
    for (Eigen::SparseMatrix<double>::InnerIterator it(group.precision, k); it;
         ++it)
      precision->emplace_back(first + it.row(), first + it.col(),
                              group.weight * it.value());
  if (group.free.cols() == 0) return;
  gradient -= group.weight * (group.unpenalized *
                              (group.unpenalized.transpose() * difference));
  const double root = std::sqrt(group.weight);
  equations->unpenalized.block(first, first_free, group.unpenalized.rows(),
                               group.unpenalized.cols()) =
      root * group.unpenalized;
  equations->free.block(first, first_free, group.free.rows(),
                        group.free.cols()) = group.free / root;
}

void AddCameraPrior(const CameraPrior& prior, int first,
                    const Eigen::VectorXd& parameters, FirstColumns columns,
                    std::vector<Eigen::Triplet<double>>* precision,
                    PriorEquations* equations) {
  const Eigen::VectorXd difference = parameters - prior.mean;
  for (const PriorGroup& group : prior.groups) {
    AddGroup(group, first, columns.free, difference, precision, equations);
    columns.free += group.free.cols();
  }
  const Eigen::MatrixXd& g = prior.orientation;
  if (g.cols() == 0) return;
  equations->gradient.segment(first, difference.size()) +=
      prior.orientation_precision * (g * prior.OrientationError(parameters));
  equations->root.block(first, columns.root, g.rows(), g.cols()) =
      std::sqrt(prior.orientation_precision) * g;
}

// Returns the operation count of the last conjugate-gradient solution, in
// equivalent operations of dense matrix products, which are faster.
double NumOperations(const std::vector<ViewJacobian>& jacobians,
                     const LargeEquations::Workspace& memory) {
  constexpr double kPerObservation = 2000;
  int num_observations = 0;
  for (const ViewJacobian& jacobian : jacobians)
    num_observations += jacobian.count();
  return kPerObservation * num_observations * memory.last_iterations();
}

}  // namespace

ParameterLayout::ParameterLayout(const AdjustmentState& state,
                                 const FixedParameters& fixed)
    : first_camera{0},
      num_points(fixed.points ? 0 : static_cast<int>(state.points.size())),
      num_poses(static_cast<int>(state.rig_from_pattern.size())),
      per_pose(6 + (state.HasPerViewDeformation() ? state.modes.count() : 0)) {
  if (!fixed.cameras && !state.cameras.empty()) {
    for (const auto& camera : state.cameras)
      first_camera.push_back(first_camera.back() + camera->NumParameters());
    first_board_pose =
        first_camera.back() + 6 * (static_cast<int>(state.cameras.size()) - 1);
  }
  first_shape = first_board_pose;
  const bool are_boards_known = fixed.cameras && fixed.points;
  if (!are_boards_known)
    first_shape += 6 * static_cast<int>(state.target_from_board.size());
  per_board = state.HasStaticDeformation() && !are_boards_known
                  ? state.modes.count()
                  : 0;
  first_point = first_shape + per_board * state.modes.num_boards();
  size = first_point + 3 * num_points;
}

AdjustmentStep ParameterLayout::UnpackStep(const Eigen::VectorXd& parameters,
                                           const Eigen::VectorXd& poses) const {
  AdjustmentStep step;
  for (size_t c = 0; c + 1 < first_camera.size(); ++c)
    step.cameras.push_back(parameters.segment(
        first_camera[c], first_camera[c + 1] - first_camera[c]));
  for (int first = first_camera.back(); first < first_board_pose; first += 6)
    step.camera_poses.push_back(parameters.segment<6>(first));
  for (int first = first_board_pose; first < first_shape; first += 6)
    step.places.push_back(parameters.segment<6>(first));
  for (int first = first_shape; first < first_point; first += per_board)
    step.flex.emplace_back(parameters.segment(first, per_board));
  step.points = parameters.tail(size - first_point);
  for (int i = 0; i < num_poses; ++i) {
    step.poses.push_back(poses.segment<6>(per_pose * i));
    if (per_pose > 6)
      step.flex.emplace_back(poses.segment(per_pose * i + 6, per_pose - 6));
  }
  return step;
}

PriorEquations::PriorEquations(const GaussianPrior& prior,
                               const AdjustmentState& state,
                               const ParameterLayout& layout)
    : precision(layout.size, layout.size),
      gradient(Eigen::VectorXd::Zero(layout.size)) {
  std::vector<Eigen::Triplet<double>> triplets;
  const size_t num_cameras = layout.has_cameras() ? prior.cameras.size() : 0;
  FirstColumns end;
  for (size_t c = 0; c < num_cameras; ++c) {
    end.root += prior.cameras[c].orientation.cols();
    end.free += NumFree(prior.cameras[c]);
  }
  root.setZero(layout.size, end.root);
  unpenalized.setZero(layout.size, end.free);
  free.setZero(layout.size, end.free);
  FirstColumns columns;
  for (size_t c = 0; c < num_cameras; ++c) {
    AddCameraPrior(prior.cameras[c], layout.first_camera[c],
                   state.cameras[c]->Parameters(), columns, &triplets, this);
    columns.root += prior.cameras[c].orientation.cols();
    columns.free += NumFree(prior.cameras[c]);
  }
  if (!prior.points_mean.empty()) {
    for (int i = 0; i < layout.num_points; ++i) {
      const int first = layout.Point(i);
      gradient.segment<3>(first) =
          prior.points_precision * (state.points[i] - prior.points_mean[i]);
      for (int k = first; k < first + 3; ++k)
        triplets.emplace_back(k, k, prior.points_precision);
    }
  }
  DeformationModes::Coefficients weights(state.modes.count());
  for (int mode = 0; mode < state.modes.count(); ++mode)
    weights[mode] = prior.DeformationPrecision(state.modes.orders[mode]);
  for (int i = layout.first_shape; i < layout.first_point; ++i) {
    const int board = (i - layout.first_shape) / layout.per_board;
    const int mode = (i - layout.first_shape) % layout.per_board;
    triplets.emplace_back(i, i, weights[mode]);
    gradient[i] = weights[mode] * state.flex[board][mode];
  }
  precision.setFromTriplets(triplets.begin(), triplets.end());
  if (!state.HasPerViewDeformation()) return;
  deformation_precision = weights;
  deformation_gradient.resize(weights.size(), layout.num_poses);
  for (int i = 0; i < layout.num_poses; ++i)
    deformation_gradient.col(i) = weights.cwiseProduct(state.flex[i]);
}

std::unique_ptr<NormalEquations> EquationsBuilder::Build(
    const GaussianPrior& prior, const FixedParameters& fixed,
    const AdjustmentState& state) {
  constexpr double kTolerance = 1e-2;
  const ParameterLayout layout(state, fixed);
  const PriorEquations prior_equations(prior, state, layout);
  std::vector<ViewJacobian> jacobians =
      WeightedJacobians(state, views_, huber_px_, num_threads_);
  if (!workspace_) workspace_ = std::make_shared<LargeEquations::Workspace>();
  const auto memory =
      std::static_pointer_cast<LargeEquations::Workspace>(workspace_);
  if (DenseIsFaster(layout, NumOperations(jacobians, *memory)))
    return std::make_unique<DenseEquations>(layout, jacobians, state.modes,
                                            prior_equations, num_threads_);
  return std::make_unique<LargeEquations>(layout, std::move(jacobians),
                                          prior_equations, state, kTolerance,
                                          num_threads_, memory);
}

}  // namespace raygrid
