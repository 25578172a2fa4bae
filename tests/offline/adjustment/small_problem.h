#ifndef RAYGRID_TESTS_OFFLINE_ADJUSTMENT_SMALL_PROBLEM_H
#define RAYGRID_TESTS_OFFLINE_ADJUSTMENT_SMALL_PROBLEM_H

#include <vector>

#include "adjustment/adjustment_state.h"
#include "adjustment/bundle_adjustment.h"
#include "adjustment/distortion_prior.h"
#include "adjustment/gaussian_prior.h"
#include "adjustment/smoothness_prior.h"
#include "support.h"

namespace raygrid {

/// Views of a board with known truth.
struct SmallProblem {
  std::vector<View> views;
  AdjustmentState state;  ///< true
};

struct SmallProblemSizes {
  int num_views = 0, num_points = 0;
  double noise_px = 0;
  int num_cameras = 1;
};

/// A board in front of ExampleLens(), every point in every view. The lens's
/// area reaches beyond the image, so that noise and steps lose no residual.
inline SmallProblem MakeSmallProblem(const SmallProblemSizes& sizes) {
  TestRandom random(21);
  SmallProblem problem;
  const OpenCvModel lens = ExampleLens().WithArea({-200, -200, 840, 680});
  problem.state.SetCamera(lens);
  for (int c = 1; c < sizes.num_cameras; ++c) {
    problem.state.cameras.push_back(lens.Clone());
    problem.state.camera_from_rig.push_back(
        {RotationFromVector({0.1 * c, -0.05, 0.2}), {-0.1 * c, 0.02, 0.01}});
  }
  for (int i = 0; i < sizes.num_points; ++i)
    problem.state.points.emplace_back(random.Uniform(-0.3, 0.3),
                                      random.Uniform(-0.2, 0.2),
                                      random.Uniform(-0.005, 0.005));
  for (int v = 0; v < sizes.num_views; ++v) {
    const Pose pose = {
        RotationFromVector({random.Uniform(-0.7, 0.7),
                            random.Uniform(-0.7, 0.7), random.Uniform(-2, 2)}),
        {random.Uniform(-0.15, 0.15), random.Uniform(-0.1, 0.1),
         random.Uniform(0.7, 1.0)}};
    problem.state.rig_from_pattern.push_back(pose);
    for (int c = 0; c < sizes.num_cameras; ++c) {
      View view;
      view.camera = c;
      view.pose = v;
      for (int i = 0; i < sizes.num_points; ++i)
        view.observations.push_back(
            {i, problem.state.cameras[c]
                        ->Project(problem.state.ComputeCameraFromPattern(view) *
                                  problem.state.points[i])
                        .value() +
                    sizes.noise_px * random.NormalVector<2>()});
      problem.views.push_back(view);
    }
  }
  return problem;
}

/// The second half of the points as a board of its own, which is fixed to the
/// first one. Nothing is seen elsewhere than before.
inline SmallProblem WithTwoBoardsOnABody(SmallProblem problem) {
  const int half = static_cast<int>(problem.state.points.size()) / 2;
  const Pose place = {RotationFromVector({0.4, -0.2, 0.7}), {0.1, -0.05, 0.03}};
  problem.state.target_from_board = {place};
  for (size_t i = half; i < problem.state.points.size(); ++i)
    problem.state.points[i] = place.Inverse() * problem.state.points[i];
  std::vector<View> views;
  for (const View& view : problem.views) {
    View first = view, second = view;
    first.observations.resize(half);
    second.observations.erase(second.observations.begin(),
                              second.observations.begin() + half);
    second.place = 0;
    views.push_back(first);
    views.push_back(second);
  }
  problem.views = std::move(views);
  return problem;
}

/// The prior of a lens's principal point, one direction of it free.
inline PriorGroup PriorOfCenter() {
  Eigen::SparseMatrix<double> precision(OpenCvModel::kCount,
                                        OpenCvModel::kCount);
  precision.insert(OpenCvModel::kCx, OpenCvModel::kCx) = 2;
  precision.insert(OpenCvModel::kCy, OpenCvModel::kCy) = 3;
  PriorGroup group;
  group.precision = precision;
  group.rank = 2;
  group.weight = 0.3;
  Eigen::MatrixXd direction = Eigen::MatrixXd::Zero(OpenCvModel::kCount, 1);
  direction(OpenCvModel::kCx) = 1;
  direction(OpenCvModel::kCy) = 0.5;
  group.Unpenalize(
      {direction, Eigen::VectorXd::Zero(1), Eigen::VectorXd::Zero(1)});
  return group;
}

/// K - R R^T of all groups of a prior, with their weights.
inline Eigen::MatrixXd WeightedPrecision(const CameraPrior& prior) {
  const Eigen::Index size = prior.mean.size();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(size, size);
  for (const PriorGroup& group : prior.groups)
    sum += group.weight * Eigen::MatrixXd(group.precision);
  for (const PriorGroup& group : prior.groups)
    if (group.unpenalized.cols() > 0)
      sum -= group.weight * group.unpenalized * group.unpenalized.transpose();
  return sum;
}

/// Every part of the prior at work, around the true state.
inline GaussianPrior PriorOf(const SmallProblem& problem) {
  GaussianPrior prior;
  for (const auto& camera : problem.state.cameras) {
    CameraPrior distortion = MakeDistortionPrior(
        dynamic_cast<const OpenCvModel&>(*camera), WholeImage({640, 480}), 0);
    distortion.mean = camera->Parameters();
    for (PriorGroup& group : distortion.groups) group.weight = 0.5;
    distortion.groups.push_back(PriorOfCenter());
    prior.cameras.push_back(distortion);
  }
  prior.points_mean = problem.state.points;
  prior.points_precision = 1e6;
  return prior;
}

/// A state to start from, away from the truth.
inline AdjustmentState Disturbed(const AdjustmentState& truth,
                                 bool move_points) {
  TestRandom random(22);
  AdjustmentState state = truth;
  for (auto& camera : state.cameras) {
    Eigen::VectorXd parameters = camera->Parameters();
    parameters.head<4>() += 5 * random.NormalVector<4>();
    parameters.tail<8>() += 0.01 * random.NormalVector<8>();
    camera->SetParameters(parameters);
  }
  for (size_t c = 1; c < state.camera_from_rig.size(); ++c)
    state.camera_from_rig[c] =
        UpdatedPose(state.camera_from_rig[c], 0.01 * random.NormalVector<6>());
  for (Pose& pose : state.rig_from_pattern)
    pose = UpdatedPose(pose, 0.01 * random.NormalVector<6>());
  for (Pose& pose : state.target_from_board)
    pose = UpdatedPose(pose, 0.01 * random.NormalVector<6>());
  if (move_points)
    for (Eigen::Vector3d& p : state.points)
      p += 0.001 * random.NormalVector<3>();
  return state;
}

/// Views of a camera with a coarse grid, exactly; the area is that of its
/// image.
inline SmallProblem MakeExactGridProblem(int num_views, int num_points) {
  SmallProblem problem = MakeSmallProblem({num_views, num_points, 0});
  problem.state.SetCamera(FittedGrid(problem.state.camera(), 260));
  for (View& view : problem.views)
    for (Observation& o : view.observations)
      o.pixel = problem.state.cameras[0]
                    ->Project(problem.state.ComputeCameraFromPattern(view) *
                                  problem.state.points[o.point],
                              &o.pixel, kAdjustmentMarginPx)
                    .value();
  return problem;
}

/// Hardly any prior around the camera's grid.
inline CameraPrior WeakGridPrior(const SmallProblem& problem) {
  CameraPrior prior = MakeSmoothnessPrior(
      dynamic_cast<const CentralGeneric&>(problem.state.camera()), {});
  prior.groups[0].weight = 1e-6;
  return prior;
}

/// That of the grid, with points that are all but fixed.
inline GaussianPrior WeakPrior(const SmallProblem& problem) {
  GaussianPrior prior;
  prior.cameras = {WeakGridPrior(problem)};
  prior.points_mean = problem.state.points;
  prior.points_precision = 1e8;
  return prior;
}

inline AdjustmentOptions FixedPoints() {
  AdjustmentOptions options;
  options.fix_points = true;
  options.num_threads = 1;
  return options;
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_ADJUSTMENT_SMALL_PROBLEM_H
