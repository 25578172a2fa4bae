#include "adjustment/deformation_modes.h"

#include "adjustment/bundle_adjustment.h"
#include "adjustment/metric_scale.h"
#include "small_problem.h"
#include "support.h"

namespace raygrid {
namespace {

std::vector<Eigen::Vector3d> Lattice(int columns, int rows) {
  std::vector<Eigen::Vector3d> points;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      points.emplace_back(0.03 * column, 0.03 * row, 0);
  return points;
}

Eigen::VectorXd HeightsOf(const DeformationModes& modes, int mode, int first,
                          int count) {
  Eigen::VectorXd heights(count);
  for (int i = 0; i < count; ++i)
    heights[i] = modes.by_point[first + i](2, mode);
  return heights;
}

TEST(DeformationModes, AreOrthogonalAndNoMotionOfTheBoard) {
  const std::vector<Eigen::Vector3d> points = Lattice(9, 6);
  const DeformationModes modes = MakeDeformationModes({{0, points}}, 54);
  ASSERT_EQ(modes.count(), 12);
  Eigen::MatrixXd heights(54, 12), motions(54, 3);
  for (int mode = 0; mode < 12; ++mode)
    heights.col(mode) = HeightsOf(modes, mode, 0, 54);
  for (int i = 0; i < 54; ++i)
    motions.row(i) << 1, points[i].x(), points[i].y();
  EXPECT_LT(
      (heights.transpose() * heights / 54 - Eigen::MatrixXd::Identity(12, 12))
          .norm(),
      1e-12);
  EXPECT_LT((motions.transpose() * heights).norm(), 1e-10);
}

TEST(DeformationModes, BelongToTheirBoard) {
  std::vector<Eigen::Vector3d> deep = Lattice(5, 5);
  for (size_t i = 0; i < deep.size(); i += 2) deep[i].z() = 0.05;
  const std::vector<Eigen::Vector3d> small = Lattice(4, 2);
  const DeformationModes modes = MakeDeformationModes(
      {{0, Lattice(6, 6)}, {36, deep}, {61, small}, {69, Lattice(2, 2)}}, 73);
  // Bends of 4 x 2 points: up to third degree along the rows, and twists.
  int small_modes = 0;
  for (int mode = 0; mode < modes.count(); ++mode) {
    EXPECT_EQ(HeightsOf(modes, mode, 36, 25).norm(), 0);
    EXPECT_EQ(HeightsOf(modes, mode, 69, 4).norm(), 0);
    small_modes += HeightsOf(modes, mode, 61, 8).norm() > 0;
  }
  EXPECT_EQ(small_modes, 8 - 3);
  EXPECT_EQ(MakeDeformationModes({{0, deep}}, 25).count(), 0);
}

TEST(DeformationModes, LeaveOutAnOrderWithItsCoefficients) {
  DeformationModes modes = MakeDeformationModes({{0, Lattice(9, 6)}}, 54);
  const DeformationModes all = modes;
  std::vector<DeformationModes::Coefficients> flex(
      1, DeformationModes::Coefficients::LinSpaced(12, 1, 12));
  modes.Remove(DeformationOrder::kThird, &flex);
  ASSERT_EQ(modes.count(), 8);
  ASSERT_EQ(flex[0].size(), 8);
  EXPECT_EQ(flex[0][2], 3);
  EXPECT_EQ(flex[0][3], 8);
  EXPECT_EQ(modes.by_point[7].col(3), all.by_point[7].col(7));
}

// A flat board seen by many, in each view or in all of them bent by so much.
SmallProblem BentProblem(double bend_m,
                         DeformationScope scope = DeformationScope::kPose) {
  SmallProblem problem = MakeSmallProblem({20, 60, 0.05});
  for (Eigen::Vector3d& point : problem.state.points) point.z() = 0;
  AdjustmentState& state = problem.state;
  state.SetModes(MakeDeformationModes({{0, state.points}}, 60), scope);
  TestRandom random(3);
  for (DeformationModes::Coefficients& flex : state.flex)
    for (int mode = 0; mode < 3; ++mode) flex[mode] = bend_m * random.Normal();
  for (View& view : problem.views)
    for (Observation& observation : view.observations)
      observation.pixel =
          state.camera()
              .Project(state.ComputeCameraFromPattern(view) *
                       state.PointAt(view.pose, observation.point))
              .value() +
          0.05 * random.NormalVector<2>();
  return problem;
}

AdjustmentState WithoutBends(const AdjustmentState& state) {
  AdjustmentState flat = state;
  flat.SetModes(state.modes, state.deformation_scope);
  return flat;
}

TEST(OptimizeWithLearnedPrior, FindsHowFarBoardsBend) {
  const SmallProblem problem = BentProblem(0.001);
  AdjustmentState state = WithoutBends(problem.state);
  GaussianPrior prior = PriorOf(problem);
  const AdjustmentSummary summary =
      OptimizeWithLearnedPrior(problem.views, {}, &prior, &state);
  EXPECT_NEAR(summary.noise_px, 0.05, 0.004);
  const double bend_m =
      summary.noise_px /
      std::sqrt(prior.DeformationPrecision(DeformationOrder::kSecond));
  EXPECT_NEAR(bend_m, 0.001, 0.0002);
  double error = 0, square = 0;
  for (size_t i = 0; i < state.flex.size(); ++i) {
    // Orders that no view has are gone.
    error += (state.flex[i].head<3>() - problem.state.flex[i].head<3>())
                 .squaredNorm();
    square += problem.state.flex[i].head<3>().squaredNorm();
  }
  EXPECT_LT(error, 0.1 * square);
}

TEST(OptimizeWithLearnedPrior, FindsThatBoardsDoNotBend) {
  const SmallProblem problem = BentProblem(0);
  AdjustmentState state = WithoutBends(problem.state);
  GaussianPrior prior = PriorOf(problem);
  OptimizeWithLearnedPrior(problem.views, {}, &prior, &state);
  for (const DeformationModes::Coefficients& flex : state.flex)
    EXPECT_LT(flex.norm(), 1e-4);
}

TEST(OptimizeWithLearnedPrior, FindsTheShapeOfABoard) {
  const SmallProblem problem = BentProblem(0.001, DeformationScope::kBoard);
  AdjustmentState state = WithoutBends(problem.state);
  GaussianPrior prior = PriorOf(problem);
  prior.points_mean = state.points;
  OptimizeWithLearnedPrior(problem.views, {}, &prior, &state);
  ASSERT_TRUE(state.HasStaticDeformation());
  // Some of it is the camera's, whose prior is weak.
  EXPECT_LT((state.flex[0].head<3>() - problem.state.flex[0].head<3>()).norm(),
            0.1 * problem.state.flex[0].norm());
  // Its points are nominal beside it, as far as the noise tells.
  for (size_t i = 0; i < state.points.size(); ++i)
    EXPECT_LT((state.points[i] - prior.points_mean[i]).norm(), 1e-5);
}

// The last points of each board are boards of their own, too small for bends.
SmallProblem WithSmallBoards(SmallProblem problem) {
  constexpr int kFirst = 39, kSize = 7;
  AdjustmentState& state = problem.state;
  std::vector<BoardPoints> boards = {
      {0, {state.points.begin(), state.points.begin() + kFirst}}};
  for (int first = kFirst; first < 60; first += kSize)
    boards.push_back(
        {first,
         {state.points.begin() + first, state.points.begin() + first + kSize}});
  const std::vector<View> views = std::move(problem.views);
  const std::vector<Pose> poses = state.rig_from_pattern;
  problem.views.clear();
  state.rig_from_pattern.clear();
  for (const View& view : views)
    for (const BoardPoints& board : boards) {
      View part = view;
      part.pose = static_cast<int>(state.rig_from_pattern.size());
      const auto first = view.observations.begin() + board.first;
      part.observations.assign(
          first, first + static_cast<std::ptrdiff_t>(board.nominal.size()));
      problem.views.push_back(part);
      state.rig_from_pattern.push_back(poses[view.pose]);
    }
  state.SetModes(MakeDeformationModes(boards, 60), DeformationScope::kBoard);
  return problem;
}

TEST(OptimizeWithLearnedPrior, FindsTheShapeOfABoardBesideSmallOnes) {
  const SmallProblem problem =
      WithSmallBoards(BentProblem(0.0003, DeformationScope::kBoard));
  AdjustmentState state = problem.state;
  GaussianPrior prior = PriorOf(problem);
  prior.points_mean = state.points;
  OptimizeWithLearnedPrior(problem.views, {}, &prior, &state);
  ASSERT_TRUE(state.HasStaticDeformation());
  EXPECT_EQ(state.modes.orders.front(), DeformationOrder::kSecond);
  EXPECT_GT(state.flex[0].head<3>().norm(), 0.0003);
}

TEST(OptimizeWithLearnedPrior, FindsThatABoardIsFlat) {
  int num_flat = 0;
  for (int seed = 0; seed < 20; ++seed) {
    SmallProblem problem = BentProblem(0, DeformationScope::kBoard);
    TestRandom random(100 + seed);
    for (View& view : problem.views)
      for (Observation& observation : view.observations)
        observation.pixel += 0.05 * random.NormalVector<2>();
    AdjustmentState state = WithoutBends(problem.state);
    GaussianPrior prior = PriorOf(problem);
    prior.points_mean = state.points;
    OptimizeWithLearnedPrior(problem.views, {}, &prior, &state);
    num_flat += !state.HasStaticDeformation();
  }
  EXPECT_GE(num_flat, 18);
}

TEST(AdjustmentState, TakesAShapeFromItsPointsAndGivesItBack) {
  const SmallProblem problem = BentProblem(0.001, DeformationScope::kBoard);
  const std::vector<Eigen::Vector3d> nominal = problem.state.points;
  AdjustmentState state = problem.state;
  state.ApplyStaticDeformation();
  EXPECT_FALSE(state.HasStaticDeformation());
  for (int i = 0; i < 60; ++i)
    EXPECT_EQ(state.points[i], problem.state.DeformedPoint(i));
  const auto before = ComputeResiduals(problem.state, problem.views, 1);
  const auto after = ComputeResiduals(state, problem.views, 1);
  for (size_t i = 0; i < before.size(); ++i)
    EXPECT_EQ(before[i].error_px, after[i].error_px);
  state.FitStaticDeformation(problem.state.modes, nominal);
  EXPECT_LT((state.flex[0] - problem.state.flex[0]).norm(), 1e-12);
  for (int i = 0; i < 60; ++i)
    EXPECT_LT((state.points[i] - nominal[i]).norm(), 1e-12);
}

// A shape that all views share is the board's.
TEST(OptimizeWithLearnedPrior, GivesTheMeanBendToTheBoard) {
  SmallProblem problem = BentProblem(0.0005);
  AdjustmentState bent = problem.state;
  for (DeformationModes::Coefficients& flex : bent.flex) flex[0] += 0.003;
  for (View& view : problem.views)
    for (Observation& observation : view.observations)
      observation.pixel =
          bent.camera()
              .Project(bent.ComputeCameraFromPattern(view) *
                       bent.PointAt(view.pose, observation.point))
              .value();
  AdjustmentState state = WithoutBends(problem.state);
  GaussianPrior prior = PriorOf(problem);
  OptimizeWithLearnedPrior(problem.views, {}, &prior, &state);
  double mean = 0;
  for (const DeformationModes::Coefficients& flex : state.flex)
    mean += flex[0] / static_cast<double>(state.flex.size());
  EXPECT_LT(std::abs(mean), 1e-5);
  double shape = 0;
  for (size_t i = 0; i < state.points.size(); ++i)
    shape += state.points[i].z() * state.modes.by_point[i](2, 0) / 60;
  EXPECT_NEAR(std::abs(shape), 0.003, 0.0005);
}

void ExpectAlignedAlike(DeformationScope scope) {
  const SmallProblem problem = BentProblem(0.001, scope);
  AdjustmentState state = problem.state;
  const Eigen::Quaterniond turn(RotationFromVector({0.02, -0.03, 0.1}));
  std::vector<Eigen::Vector3d> nominal;
  for (int i = 0; i < 60; ++i)
    nominal.push_back(1.1 * (turn * state.DeformedPoint(i)) +
                      Eigen::Vector3d(0.1, 0.2, 0));
  std::vector<int> poses(state.rig_from_pattern.size());
  for (size_t i = 0; i < poses.size(); ++i) poses[i] = static_cast<int>(i);
  AlignToNominal({{0, nominal, poses}}, &state);
  const auto before = ComputeResiduals(problem.state, problem.views, 1);
  const auto after = ComputeResiduals(state, problem.views, 1);
  for (size_t i = 0; i < before.size(); ++i)
    EXPECT_LT((before[i].error_px - after[i].error_px).norm(), 1e-7);
  EXPECT_LT((state.DeformedPoint(5) - nominal[5]).norm(), 1e-9);
}

TEST(AlignToNominal, ChangesNoResidualOfBentBoards) {
  ExpectAlignedAlike(DeformationScope::kPose);
  ExpectAlignedAlike(DeformationScope::kBoard);
}

}  // namespace
}  // namespace raygrid
