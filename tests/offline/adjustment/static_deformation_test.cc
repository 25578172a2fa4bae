#include "adjustment/static_deformation.h"

#include <gtest/gtest.h>

#include "support.h"

namespace raygrid {
namespace {

// Three boards of which the second is not bent by the modes there are; points
// of the others take turns.
AdjustmentState BentBoards() {
  TestRandom random(7);
  AdjustmentState state;
  state.SetCamera(ExampleLens());
  state.rig_from_pattern.resize(2);
  DeformationModes modes;
  modes.orders = {DeformationOrder::kSecond, DeformationOrder::kFourth};
  modes.boards = {0, 2, 0, 2, 1, 0, 2};
  for (const int board : modes.boards) {
    DeformationModes::Displacement displacement =
        DeformationModes::Displacement::Zero(3, 2);
    for (int k = 0; k < 6 && board != 1; ++k)
      displacement.data()[k] = random.Normal();
    modes.by_point.push_back(displacement);
    state.points.push_back(random.NormalVector<3>());
  }
  state.SetModes(modes, DeformationScope::kBoard);
  return state;
}

Eigen::MatrixXd Drawn(Eigen::Index rows, Eigen::Index columns) {
  TestRandom random(8);
  Eigen::MatrixXd result(rows, columns);
  for (Eigen::Index k = 0; k < result.size(); ++k)
    result.data()[k] = random.Normal();
  return result;
}

class StaticDeformationOf : public testing::TestWithParam<FixedParameters> {
 protected:
  const AdjustmentState state_ = BentBoards();
  const ParameterLayout layout_{state_, GetParam()};
  const StaticDeformation moves_{layout_, state_.modes};
};

TEST_P(StaticDeformationOf, MovePointsOfTheirBoards) {
  ASSERT_EQ(layout_.first_point - layout_.first_shape, 2 * 3);
  const ParameterLayout& moved = moves_.moved();
  ASSERT_EQ(moved.num_points, static_cast<int>(state_.points.size()));
  const Eigen::MatrixXd x = Drawn(layout_.size, 3);
  const Eigen::MatrixXd y = moves_.MapToPoints(x);
  EXPECT_EQ(y.topRows(moved.first_point), x.topRows(layout_.first_shape));
  for (int i = 0; i < moved.num_points; ++i) {
    Eigen::MatrixXd expected =
        state_.modes.by_point[i] *
        x.middleRows(layout_.Shape(state_.modes.boards[i]), 2);
    if (layout_.num_points > 0) expected += x.middleRows(layout_.Point(i), 3);
    EXPECT_LT((y.middleRows(moved.Point(i), 3) - expected).norm(), 1e-12);
  }
}

TEST_P(StaticDeformationOf, GoBackByTheTranspose) {
  const Eigen::MatrixXd all = moves_.MapToPoints<Eigen::MatrixXd>(
      Eigen::MatrixXd::Identity(layout_.size, layout_.size));
  const Eigen::MatrixXd y = Drawn(moves_.moved().size, 3);
  EXPECT_LT((moves_.MapToModes(y) - all.transpose() * y).norm(), 1e-12);
  Eigen::MatrixXd of_points =
      Eigen::MatrixXd::Zero(3 * moves_.moved().num_points, moves_.NumModes());
  moves_.ForEachPoint([&](int point, int first, const auto& move) {
    of_points.block(3 * point, first, 3, move.cols()) = move;
  });
  EXPECT_EQ(of_points, all.middleCols(layout_.first_shape, moves_.NumModes())
                           .bottomRows(of_points.rows()));
}

TEST_P(StaticDeformationOf, MoveABasis) {
  const Eigen::MatrixXd whole = Drawn(layout_.size, 4);
  const CoarseBasis basis = whole.sparseView();
  EXPECT_LT(
      (Eigen::MatrixXd(moves_.MapToPoints(basis)) - moves_.MapToPoints(whole))
          .norm(),
      1e-12);
}

INSTANTIATE_TEST_SUITE_P(FixedOrNot, StaticDeformationOf,
                         testing::Values(FixedParameters{false, false},
                                         FixedParameters{false, true},
                                         FixedParameters{true, false}));

TEST(StaticDeformation, ChangeNothingWithoutBends) {
  AdjustmentState state = BentBoards();
  state.SetModes(state.modes, DeformationScope::kPose);
  const ParameterLayout layout(state, {});
  const StaticDeformation moves(layout, state.modes);
  const Eigen::MatrixXd x = Drawn(layout.size, 2);
  EXPECT_EQ(moves.MapToPoints(x), x);
  EXPECT_EQ(moves.MapToModes(x), x);
}

}  // namespace
}  // namespace raygrid
