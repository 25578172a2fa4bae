#include "adjustment/linear_response.h"

#include "adjustment/dense_equations.h"
#include "adjustment/large_equations.h"
#include "adjustment/residual_product.h"
#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

constexpr double kTolerance = 1e-2;

}  // namespace

LinearResponse::LinearResponse(const std::vector<View>& views,
                               const GaussianPrior& prior,
                               const AdjustmentOptions& options,
                               const AdjustmentState& state,
                               int max_exact_unknowns)
    : layout_(state, {false, options.fix_points}),
      prior_(prior, state, layout_),
      static_deformation_(layout_, state.modes),
      jacobians_(WeightedJacobians(state, views, options.huber_px,
                                   options.num_threads)),
      is_exact_(NumDenseUnknowns(layout_) <= max_exact_unknowns),
      prior_root_(prior_.precision) {
  const int num_threads = NumThreads(options.num_threads);
  if (is_exact_)
    equations_ = std::make_unique<DenseEquations>(
        layout_, jacobians_, state.modes, prior_, num_threads);
  else
    equations_ = std::make_unique<LargeEquations>(
        layout_, jacobians_, prior_, state, kTolerance, num_threads,
        std::make_shared<LargeEquations::Workspace>());
}

Eigen::VectorXd LinearResponse::Gradient(const ViewErrors& errors) const {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(layout_.num_all());
  Eigen::VectorXd moved =
      Eigen::VectorXd::Zero(static_deformation_.moved().size);
  for (size_t v = 0; v < jacobians_.size(); ++v) {
    const ViewJacobian& j = jacobians_[v];
    const ResidualProduct product(static_deformation_.moved(), j);
    for (int i = 0; i < j.count(); ++i) {
      const Eigen::Vector2d error = errors[v].col(i);
      product.AddTransposed<1>(error, i, &moved);
      gradient.segment(layout_.Pose(j.pose), layout_.per_pose).noalias() +=
          j.PoseJacobian(i) * error;
    }
  }
  gradient.head(layout_.size) = static_deformation_.MapToModes(moved);
  return gradient;
}

ViewErrors LinearResponse::ApplyJacobian(
    const Eigen::VectorXd& parameters) const {
  ViewErrors errors;
  const Eigen::VectorXd moved =
      static_deformation_.MapToPoints<Eigen::VectorXd>(
          parameters.head(layout_.size));
  for (const ViewJacobian& j : jacobians_) {
    const ResidualProduct product(static_deformation_.moved(), j);
    const Eigen::VectorXd pose =
        parameters.segment(layout_.Pose(j.pose), layout_.per_pose);
    Eigen::Matrix2Xd& own = errors.emplace_back(2, j.count());
    for (int i = 0; i < j.count(); ++i)
      own.col(i) =
          product.Times<1>(moved, i) + j.PoseJacobian(i).transpose() * pose;
  }
  return errors;
}

ViewErrors LinearResponse::SampleNoise(std::mt19937* random_bits) const {
  ViewErrors errors;
  for (const ViewJacobian& view : jacobians_)
    errors.push_back(
        RandomSigns(2 * view.count(), random_bits).reshaped(2, view.count()));
  return errors;
}

// Draws a prior gradient with the precision P = B B^T + R R^T as covariance.
Eigen::VectorXd LinearResponse::SamplePrior(std::mt19937* random_bits) const {
  // Separate statements fix the order of the draws for all compilers.
  const Eigen::VectorXd root_signs =
      RandomSigns(prior_root_.size(), random_bits);
  const Eigen::VectorXd other_signs =
      RandomSigns(prior_.root.cols(), random_bits);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(layout_.num_all());
  gradient.head(layout_.size) =
      ProjectOutUnpenalized(prior_.free, prior_.unpenalized,
                            prior_root_.Times(root_signs, layout_.size)) +
      prior_.root * other_signs;
  return gradient;
}

Eigen::VectorXd LinearResponse::SampleDeformationPrior(
    std::mt19937* random_bits) const {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(layout_.num_all());
  const Eigen::Index num_modes = prior_.deformation_precision.size();
  for (int pose = 0; num_modes > 0 && pose < layout_.num_poses; ++pose)
    gradient.segment(layout_.Pose(pose) + 6, num_modes) =
        prior_.deformation_precision.cwiseSqrt().cwiseProduct(
            RandomSigns(num_modes, random_bits));
  return gradient;
}

Eigen::VectorXd LinearResponse::PriorGradient() const {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(layout_.num_all());
  gradient.head(layout_.size) = prior_.gradient;
  return gradient;
}

}  // namespace raygrid
