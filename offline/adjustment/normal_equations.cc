#include "adjustment/normal_equations.h"

#include "adjustment/dense_equations.h"
#include "adjustment/large_equations.h"

namespace raygrid {
namespace {

void AddCameraPrior(const CameraPrior& prior, int first,
                    const Eigen::VectorXd& parameters, int first_column,
                    std::vector<Eigen::Triplet<double>>* precision,
                    PriorEquations* equations) {
  const Eigen::VectorXd difference = parameters - prior.mean;
  auto gradient = equations->gradient.segment(first, difference.size());
  for (const PriorGroup& group : prior.groups) {
    gradient += group.weight * (group.precision * difference);
    for (int k = 0; k < group.precision.outerSize(); ++k)
      for (Eigen::SparseMatrix<double>::InnerIterator it(group.precision, k);
           it; ++it)
        precision->emplace_back(first + it.row(), first + it.col(),
                                group.weight * it.value());
  }
  const Eigen::MatrixXd& g = prior.orientation;
  if (g.cols() == 0) return;
  gradient += prior.orientation_weight * (g * (g.transpose() * difference));
  equations->root.block(first, first_column, g.rows(), g.cols()) =
      std::sqrt(prior.orientation_weight) * g;
}

}  // namespace

ParameterLayout::ParameterLayout(const AdjustmentState& state,
                                 const FixedParameters& fixed)
    : first_camera{0},
      num_points(fixed.points ? 0 : static_cast<int>(state.points.size())),
      num_poses(static_cast<int>(state.rig_from_pattern.size())) {
  first_point = 0;
  if (!fixed.cameras && !state.cameras.empty()) {
    for (const auto& camera : state.cameras)
      first_camera.push_back(first_camera.back() + camera->NumParameters());
    first_point =
        first_camera.back() + 6 * (static_cast<int>(state.cameras.size()) - 1);
  }
  size = first_point + 3 * num_points;
}

AdjustmentStep ParameterLayout::Step(const Eigen::VectorXd& parameters,
                                     const Eigen::VectorXd& poses) const {
  AdjustmentStep step;
  for (size_t c = 0; c + 1 < first_camera.size(); ++c)
    step.cameras.push_back(parameters.segment(
        first_camera[c], first_camera[c + 1] - first_camera[c]));
  for (int first = first_camera.back(); first < first_point; first += 6)
    step.camera_poses.push_back(parameters.segment<6>(first));
  step.points = parameters.tail(size - first_point);
  for (int i = 0; i < num_poses; ++i)
    step.poses.push_back(poses.segment<6>(6 * i));
  return step;
}

PriorEquations::PriorEquations(const GaussianPrior& prior,
                               const AdjustmentState& state,
                               const ParameterLayout& layout)
    : precision(layout.size, layout.size),
      gradient(Eigen::VectorXd::Zero(layout.size)) {
  std::vector<Eigen::Triplet<double>> triplets;
  Eigen::Index num_columns = 0;
  if (layout.has_cameras())
    for (const CameraPrior& camera : prior.cameras)
      num_columns += camera.orientation.cols();
  root.setZero(layout.size, num_columns);
  int column = 0;
  for (size_t c = 0; layout.has_cameras() && c < prior.cameras.size(); ++c) {
    AddCameraPrior(prior.cameras[c], layout.first_camera[c],
                   state.cameras[c]->Parameters(), column, &triplets, this);
    column += static_cast<int>(prior.cameras[c].orientation.cols());
  }
  if (!prior.points_mean.empty()) {
    for (int i = 0; i < layout.num_points; ++i) {
      const int first = layout.Point(i);
      gradient.segment<3>(first) =
          prior.points_weight * (state.points[i] - prior.points_mean[i]);
      for (int k = first; k < first + 3; ++k)
        triplets.emplace_back(k, k, prior.points_weight);
    }
  }
  precision.setFromTriplets(triplets.begin(), triplets.end());
}

std::unique_ptr<NormalEquations> EquationsBuilder::Build(
    const GaussianPrior& prior, const FixedParameters& fixed,
    const AdjustmentState& state) {
  constexpr double kTolerance = 1e-2;
  const ParameterLayout layout(state, fixed);
  const PriorEquations prior_equations(prior, state, layout);
  std::vector<ViewJacobian> jacobians =
      WeightedJacobians(state, views_, huber_px_, num_threads_);
  if (DenseIsFaster(layout))
    return std::make_unique<DenseEquations>(layout, jacobians, prior_equations,
                                            num_threads_);
  if (!memory_) memory_ = std::make_shared<LargeEquations::Memory>();
  return std::make_unique<LargeEquations>(
      layout, std::move(jacobians), prior_equations, state.points, kTolerance,
      num_threads_, std::static_pointer_cast<LargeEquations::Memory>(memory_));
}

}  // namespace raygrid
