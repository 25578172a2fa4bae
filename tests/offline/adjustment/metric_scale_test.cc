#include "adjustment/metric_scale.h"

#include "adjustment/reprojection_error.h"
#include "small_problem.h"
#include "support.h"

namespace raygrid {
namespace {

// The board scaled, turned and moved, and all poses such that every point is
// seen where it was.
AdjustmentState MapToPoints(const AdjustmentState& state) {
  const double scale = 1.7;
  const Eigen::Quaterniond rotation = RotationFromVector({0.3, -0.5, 0.2});
  const Eigen::Vector3d shift(0.4, -0.2, 0.6);
  AdjustmentState moved = state;
  for (Eigen::Vector3d& point : moved.points)
    point = scale * (rotation * point) + shift;
  for (Pose& pose : moved.rig_from_pattern) {
    const Eigen::Quaterniond turned = pose.rotation * rotation.inverse();
    pose = {turned, scale * pose.translation - turned * shift};
  }
  return moved;
}

TEST(AlignToNominal, RestoresAScaledAndMovedBoard) {
  const SmallProblem problem = MakeSmallProblem({5, 20, 0});
  AdjustmentState state = MapToPoints(problem.state);
  AlignToNominal({{0, problem.state.points, {0, 1, 2, 3, 4}}}, &state);
  for (size_t i = 0; i < state.points.size(); ++i)
    EXPECT_LT((state.points[i] - problem.state.points[i]).norm(), 1e-12);
  for (size_t v = 0; v < problem.views.size(); ++v) {
    const Pose& found = state.rig_from_pattern[v];
    const Pose& truth = problem.state.rig_from_pattern[v];
    EXPECT_LT((found.translation - truth.translation).norm(), 1e-11);
    EXPECT_LT(found.rotation.angularDistance(truth.rotation), 1e-7);
  }
}

TEST(AlignToNominal, ChangesNoReprojection) {
  const SmallProblem problem = MakeSmallProblem({5, 20, 0.5});
  TestRandom random(3);
  AdjustmentState state = MapToPoints(problem.state);
  for (Eigen::Vector3d& p : state.points) p += 0.002 * random.NormalVector<3>();
  const auto before = ComputeResiduals(state, problem.views, 1);
  AlignToNominal({{0, problem.state.points, {0, 1, 2, 3, 4}}}, &state);
  const auto after = ComputeResiduals(state, problem.views, 1);
  for (size_t i = 0; i < before.size(); ++i)
    EXPECT_LT((before[i].error_px - after[i].error_px).norm(), 1e-8);
}

TEST(AlignToNominal, LeavesTheScaleToACameraWhoseLinesDoNotMeet) {
  const SmallProblem problem = MakeSmallProblem({5, 20, 0});
  AdjustmentState state = problem.state;
  state.SetCamera(ExampleLines());
  for (Eigen::Vector3d& point : state.points)
    point = 1.01 * point + Eigen::Vector3d(0.01, 0, 0.02);
  const auto before = ComputeResiduals(state, problem.views, 1);
  const double extent = (state.points[0] - state.points[19]).norm();
  AlignToNominal({{0, problem.state.points, {0, 1, 2, 3, 4}}}, &state);
  EXPECT_NEAR((state.points[0] - state.points[19]).norm(), extent, 1e-12);
  const auto after = ComputeResiduals(state, problem.views, 1);
  for (size_t i = 0; i < before.size(); ++i)
    EXPECT_LT((before[i].error_px - after[i].error_px).norm(), 1e-7);
}

TEST(AlignToNominal, LeavesOtherBoardsAndTheirViewsAlone) {
  const SmallProblem problem = MakeSmallProblem({4, 20, 0});
  const AdjustmentState moved = MapToPoints(problem.state);
  AdjustmentState state = moved;
  const std::vector<Eigen::Vector3d> nominal(problem.state.points.begin() + 10,
                                             problem.state.points.end());
  AlignToNominal({{10, nominal, {2}}}, &state);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(state.points[i], moved.points[i]);
  for (int i = 10; i < 20; ++i)
    EXPECT_LT((state.points[i] - problem.state.points[i]).norm(), 1e-12);
  for (const int v : {0, 1, 3})
    EXPECT_EQ(state.rig_from_pattern[v].translation,
              moved.rig_from_pattern[v].translation);
  EXPECT_LT((state.rig_from_pattern[2].translation -
             problem.state.rig_from_pattern[2].translation)
                .norm(),
            1e-11);
}

constexpr SmallProblemSizes kRig = {5, 20, 0.5, 2};

TEST(AlignToNominal, BringsTheCamerasOfARigAlong) {
  const SmallProblem problem = MakeSmallProblem(kRig);
  AdjustmentState state = MapToPoints(problem.state);
  state.camera_from_rig[1].translation *= 1.7;
  AlignToNominal({{0, problem.state.points, {0, 1, 2, 3, 4}}}, &state);
  EXPECT_LT((state.camera_from_rig[1].translation -
             problem.state.camera_from_rig[1].translation)
                .norm(),
            1e-12);
}

// The second half of the points is a board of its own, in views of its own.
SmallProblem TwoBoards() {
  SmallProblem problem = MakeSmallProblem(kRig);
  const size_t num_views = problem.views.size();
  const std::vector<Pose> poses = problem.state.rig_from_pattern;
  problem.state.rig_from_pattern.insert(problem.state.rig_from_pattern.end(),
                                        poses.begin(), poses.end());
  for (size_t v = 0; v < num_views; ++v) {
    View first = problem.views[v], second = first;
    first.observations.resize(10);
    second.observations.erase(second.observations.begin(),
                              second.observations.begin() + 10);
    second.pose += static_cast<int>(poses.size());
    problem.views[v] = first;
    problem.views.push_back(second);
  }
  return problem;
}

TEST(AlignToNominal, GivesTheBoardsOfARigOneScaleAndChangesNoReprojection) {
  const SmallProblem problem = TwoBoards();
  const std::vector<Eigen::Vector3d>& nominal = problem.state.points;
  TestRandom random(3);
  AdjustmentState state = problem.state;
  for (int i = 0; i < 20; ++i) {
    Eigen::Vector3d& point = state.points[i];
    point = (i < 10 ? 1.01 : 1.03) * point + 1e-4 * random.NormalVector<3>();
  }
  const auto before = ComputeResiduals(state, problem.views, 1);
  AlignToNominal({{0, {nominal.begin(), nominal.begin() + 10}, {0, 1, 2, 3, 4}},
                  {10, {nominal.begin() + 10, nominal.end()}, {5, 6, 7, 8, 9}}},
                 &state);
  const auto after = ComputeResiduals(state, problem.views, 1);
  for (size_t i = 0; i < before.size(); ++i)
    EXPECT_LT((before[i].error_px - after[i].error_px).norm(), 1e-8);
  const double scale = state.camera_from_rig[1].translation.norm() /
                       problem.state.camera_from_rig[1].translation.norm();
  EXPECT_GT(scale, 1 / 1.028);
  EXPECT_LT(scale, 1 / 1.012);
}

TEST(AlignToNominal, GivesTheBoardsOfABodyOneScaleAndChangesNoReprojection) {
  for (const int num_cameras : {1, 2}) {
    const SmallProblem problem =
        WithTwoBoardsOnABody(MakeSmallProblem({5, 20, 0.5, num_cameras}));
    const std::vector<Eigen::Vector3d>& nominal = problem.state.points;
    TestRandom random(3);
    AdjustmentState state = MapToPoints(problem.state);
    for (int i = 0; i < 20; ++i)
      state.points[i] += 1e-4 * random.NormalVector<3>();
    const auto before = ComputeResiduals(state, problem.views, 1);
    AlignToNominal(
        {{0, {nominal.begin(), nominal.begin() + 10}, {0, 1, 2, 3, 4}, 0, -1},
         {10, {nominal.begin() + 10, nominal.end()}, {}, 0, 0}},
        &state);
    const auto after = ComputeResiduals(state, problem.views, 1);
    for (size_t i = 0; i < before.size(); ++i)
      EXPECT_LT((before[i].error_px - after[i].error_px).norm(), 1e-8);
    for (int i = 0; i < 20; ++i)
      EXPECT_LT((state.points[i] - nominal[i]).norm(), 1e-2);
  }
}

}  // namespace
}  // namespace raygrid
