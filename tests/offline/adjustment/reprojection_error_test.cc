#include "adjustment/reprojection_error.h"

#include "simulation/simulated_camera.h"
#include "small_problem.h"
#include "support.h"

namespace raygrid {
namespace {

SmallProblem SmallGridProblem() {
  SmallProblem problem = MakeSmallProblem({4, 30, 0.3});
  problem.state.SetCamera(FittedGrid(problem.state.camera(), 60));
  return problem;
}

SmallProblem BentProblem() {
  SmallProblem problem = MakeSmallProblem({3, 30, 0.3, 2});
  for (Eigen::Vector3d& point : problem.state.points) point.z() = 0;
  problem.state.SetModes(MakeDeformationModes({{0, problem.state.points}}, 30),
                         DeformationScope::kPose);
  TestRandom random(5);
  for (DeformationModes::Coefficients& flex : problem.state.flex)
    for (Eigen::Index k = 0; k < flex.size(); ++k)
      flex[k] = 1e-3 * random.Normal();
  return problem;
}

// The residual of one observation as a function of a changed state.
Eigen::VectorXd ResidualOf(const AdjustmentState& state, const View& view) {
  AdjustmentState copy = state;
  return ComputeResiduals(copy, {view}, 1).front().error_px;
}

// One view with one observation, out of a problem.
struct Single {
  AdjustmentState state;
  View view;
};

Single Extract(const SmallProblem& problem, size_t view, size_t observation) {
  Single single;
  single.state = problem.state;
  const Observation& seen = problem.views[view].observations[observation];
  single.state.points = {problem.state.points[seen.point]};
  single.state.rig_from_pattern = {
      problem.state.rig_from_pattern[problem.views[view].pose]};
  if (problem.state.modes.count() > 0) {
    single.state.modes.by_point = {problem.state.modes.by_point[seen.point]};
    single.state.flex = {problem.state.flex[problem.views[view].pose]};
  }
  single.view.camera = problem.views[view].camera;
  single.view.place = problem.views[view].place;
  single.view.observations = {{0, seen.pixel}};
  return single;
}

void ExpectDerivatives(const Single& single) {
  const LinearizedResidual linear =
      LinearizeView(single.state, single.view).front();
  ASSERT_TRUE(linear.residual.valid);
  EXPECT_LT(
      (linear.residual.error_px - ResidualOf(single.state, single.view)).norm(),
      1e-9);
  const auto J_pose = [&](const Eigen::VectorXd& update) {
    AdjustmentState changed = single.state;
    Pose& pose = changed.rig_from_pattern[0];
    pose = UpdatedPose(pose, update);
    return ResidualOf(changed, single.view);
  };
  const auto J_camera_pose = [&](const Eigen::VectorXd& update) {
    AdjustmentState changed = single.state;
    Pose& pose = changed.camera_from_rig[single.view.camera];
    pose = UpdatedPose(pose, update);
    return ResidualOf(changed, single.view);
  };
  const auto J_point = [&](const Eigen::VectorXd& point) {
    AdjustmentState changed = single.state;
    changed.points[0] = point;
    return ResidualOf(changed, single.view);
  };
  const Eigen::Matrix<double, 6, 1> zero = Eigen::Matrix<double, 6, 1>::Zero();
  EXPECT_LT(
      RelativeDifference(linear.J_pose, CentralDifference(J_pose, zero, 1e-6)),
      1e-5);
  EXPECT_LT(RelativeDifference(linear.J_camera_pose,
                               CentralDifference(J_camera_pose, zero, 1e-6)),
            1e-5);
  EXPECT_LT(RelativeDifference(
                linear.J_point,
                CentralDifference(J_point, single.state.points[0], 1e-6)),
            1e-5);
  if (single.view.place >= 0) {
    const auto J_board_pose = [&](const Eigen::VectorXd& update) {
      AdjustmentState changed = single.state;
      Pose& pose = changed.target_from_board[single.view.place];
      pose = UpdatedPose(pose, update);
      return ResidualOf(changed, single.view);
    };
    EXPECT_LT(RelativeDifference(linear.J_board_pose,
                                 CentralDifference(J_board_pose, zero, 1e-6)),
              1e-5);
  }
  if (single.state.modes.count() == 0) return;
  const auto J_deformation = [&](const Eigen::VectorXd& flex) {
    AdjustmentState changed = single.state;
    changed.flex[0] = flex;
    return ResidualOf(changed, single.view);
  };
  EXPECT_LT(RelativeDifference(
                linear.J_deformation,
                CentralDifference(J_deformation, single.state.flex[0], 1e-6)),
            1e-5);
}

TEST(ReprojectionError, DerivativesAreThoseOfTheResiduals) {
  for (const SmallProblem& problem :
       {MakeSmallProblem({4, 30, 0.3}), MakeSmallProblem({3, 30, 0.3, 2}),
        WithTwoBoardsOnABody(MakeSmallProblem({3, 30, 0.3, 2})),
        SmallGridProblem(), BentProblem()})
    for (size_t view = 0; view < problem.views.size(); ++view)
      for (size_t i = 0; i < 10; ++i)
        ExpectDerivatives(Extract(problem, view, i));
}

TEST(ReprojectionError, IsProjectionMinusObservation) {
  const SmallProblem problem = MakeSmallProblem({2, 20, 0});
  std::vector<View> views = problem.views;
  const Eigen::Vector2d shift(0.3, -0.7);
  for (Observation& o : views[1].observations) o.pixel += shift;
  const std::vector<Residual> residuals =
      ComputeResiduals(problem.state, views, 1);
  ASSERT_EQ(residuals.size(), 40u);
  for (size_t i = 0; i < residuals.size(); ++i) {
    const Eigen::Vector2d expected = i < 20 ? Eigen::Vector2d(0, 0) : -shift;
    EXPECT_LT((residuals[i].error_px - expected).norm(), 1e-9);
  }
}

TEST(ReprojectionError, DoesNotDependOnTheNumberOfThreads) {
  const SmallProblem problem = MakeSmallProblem({7, 30, 0.3});
  const auto one = ComputeResiduals(problem.state, problem.views, 1);
  const auto three = ComputeResiduals(problem.state, problem.views, 3);
  ASSERT_EQ(one.size(), three.size());
  for (size_t i = 0; i < one.size(); ++i)
    EXPECT_EQ(one[i].error_px, three[i].error_px);
}

TEST(ReprojectionError, PointsThatAreNotSeenHaveNone) {
  SmallProblem problem = MakeSmallProblem({2, 20, 0});
  problem.state.rig_from_pattern[0].translation.z() -= 10;  // behind
  const auto residuals = ComputeResiduals(problem.state, problem.views, 1);
  for (size_t i = 0; i < residuals.size(); ++i)
    EXPECT_EQ(residuals[i].valid, i >= 20);
  for (const bool second : {false, true})
    for (const LinearizedResidual& linear :
         LinearizeView(problem.state, problem.views[second]))
      EXPECT_EQ(linear.residual.valid, second);
}

TEST(HuberLoss, IsQuadraticThenLinearAndItsWeightItsSlope) {
  EXPECT_DOUBLE_EQ(HuberLoss(0.6, 1), 0.18);
  EXPECT_DOUBLE_EQ(HuberLoss(5, 2), 8);
  for (const double norm : {0.1, 0.9, 1.1, 3.0, 50.0}) {
    const double slope =
        (HuberLoss(norm + 1e-6, 1) - HuberLoss(norm - 1e-6, 1)) / 2e-6;
    EXPECT_NEAR(HuberWeight(norm, 1) * norm, slope, 1e-6);
  }
}

TEST(CompareCosts, CountsOnlyResidualsThatAreValidInBoth) {
  const Residual none, small = {true, {0.6, 0}}, large = {true, {0, 5}};
  const ComparableCosts costs =
      CompareCosts({small, large, none, large}, {large, none, small, small}, 2);
  EXPECT_EQ(costs.num_common, 2);
  EXPECT_DOUBLE_EQ(costs.first, 0.18 + 8);
  EXPECT_DOUBLE_EQ(costs.second, 8 + 0.18);
}

}  // namespace
}  // namespace raygrid
