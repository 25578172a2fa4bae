#include "camera/operating_point_grid.h"

#include "support.h"

namespace raygrid {
namespace {

void Disturb(OperatingPointModel* stack) {
  TestRandom random(3);
  for (size_t j = 1; j < stack->terms().size(); ++j)
    for (Eigen::Vector2d& point : stack->terms()[j].points())
      point = 2e-3 * random.NormalVector<2>();
}

// A lens that changes by some pixels, and all over the place.
OperatingPointModel UnevenStack() {
  OperatingPointModel stack(
      {{OperatingParameter::kLensPosition, 1, 5}}, {3},
      FitCentralGeneric(ExampleSimulatedCamera(), {0, 0, 639, 479}, 9, 8));
  Disturb(&stack);
  return stack;
}

// A lens that changes with two conditions, 1 to 5 and 20 to 60.
OperatingPointModel UnevenStackOfBoth() {
  OperatingPointModel stack(
      {{OperatingParameter::kLensPosition, 1, 5},
       {OperatingParameter::kTemperature, 20, 60}},
      {3, 2},
      FitCentralGeneric(ExampleSimulatedCamera(), {0, 0, 639, 479}, 9, 8));
  Disturb(&stack);
  return stack;
}

// Files have deviations at a range's ends, which are looked for there.
TEST(OperatingRange, SpreadEndsAtItsEnds) {
  const OperatingRange range = {OperatingParameter::kTemperature, 30.8, 63.9};
  const std::vector<double> values = range.SampleValues(5);
  ASSERT_EQ(values.size(), 5u);
  EXPECT_EQ(values.front(), 30.8);
  EXPECT_EQ(values.back(), 63.9);
  EXPECT_NEAR(values[2], range.Center(), 1e-12);
}

TEST(OperatingPointModel, IsItsFirstTermInTheMiddle) {
  const OperatingPointModel stack = UnevenStack();
  EXPECT_EQ(stack.At({3}).Parameters(),
            CentralGeneric({640, 480}, stack.terms()[0]).Parameters());
}

TEST(OperatingPointModel, IsAPolynomialOfTheCondition) {
  const OperatingPointModel stack = UnevenStack();
  // t is -1 at 1, 1 at 5, and 1/2 at 4.
  for (const auto& [value, t] :
       {std::pair(1.0, -1.0), std::pair(5.0, 1.0), std::pair(4.0, 0.5)}) {
    const Eigen::Vector2d expected =
        stack.terms()[0].points()[20] +
        t * (stack.terms()[1].points()[20] +
             t * (stack.terms()[2].points()[20] +
                  t * stack.terms()[3].points()[20]));
    EXPECT_LT((stack.At({value}).surface().points()[20] - expected).norm(),
              1e-15);
  }
}

TEST(OperatingPointGrid, SeesAsTheCameraAtItsValue) {
  const OperatingPointModel stack = UnevenStack();
  OperatingPointGrid camera(stack, {2});
  ExpectRoundTrip(camera, 1e-6);
  const Eigen::Vector2d pixel(100, 300);
  EXPECT_EQ(*camera.Unproject(pixel), *stack.At({2}).Unproject(pixel));
  camera.SetValues({4.5});
  EXPECT_EQ(*camera.Unproject(pixel), *stack.At({4.5}).Unproject(pixel));
}

TEST(OperatingPointGrid, DerivativesAreThoseOfProjection) {
  for (const double value : {1.0, 2.5, 4.9}) {
    const OperatingPointGrid camera(UnevenStack(), {value});
    ExpectDerivativeByPoint(camera, 1e-6);
    ExpectDerivativeByParameter(camera, 1e-5, 1e-5);
  }
}

TEST(OperatingPointGrid, ParametersAreThoseOfTheWholeStack) {
  const OperatingPointGrid camera(UnevenStack(), {2});
  OperatingPointGrid other(
      OperatingPointModel(
          {{OperatingParameter::kLensPosition, 1, 5}}, {3},
          CentralGeneric({640, 480}, camera.stack().terms()[1])),
      {4});
  other.SetParameters(camera.Parameters());
  EXPECT_EQ(other.Parameters(), camera.Parameters());
  EXPECT_EQ(other.stack().At({2}).Parameters(), camera.camera().Parameters());
  EXPECT_EQ(other.values(), OperatingPoint{4});
}

TEST(OperatingPointModel, OfTwoConditionsIsASumOfPolynomials) {
  const OperatingPointModel stack = UnevenStackOfBoth();
  EXPECT_EQ(stack.EvaluateBasis({4, 30}),
            (std::vector<double>{1, 0.5, 0.25, 0.125, -0.5, 0.25}));
  EXPECT_EQ(stack.FirstTerm(0), 1);
  EXPECT_EQ(stack.FirstTerm(1), 4);
  const auto change = [&](const OperatingPoint& values) {
    return Eigen::VectorXd(stack.At(values).Parameters() -
                           stack.At(stack.Center()).Parameters());
  };
  EXPECT_LT((change({4, 30}) - change({4, 40}) - change({3, 30}))
                .cwiseAbs()
                .maxCoeff(),
            1e-15);
}

TEST(OperatingPointModel, WhereConditionsAreHeldIsAStackOverTheOthers) {
  const OperatingPointModel stack = UnevenStackOfBoth();
  const auto expect_same = [](const CentralGeneric& a,
                              const CentralGeneric& b) {
    EXPECT_LT((a.Parameters() - b.Parameters()).cwiseAbs().maxCoeff(), 1e-15);
  };
  const OperatingPointModel warm = stack.FixValues({std::nullopt, 55});
  ASSERT_EQ(warm.ranges().size(), 1u);
  EXPECT_EQ(warm.ranges()[0].condition, OperatingParameter::kLensPosition);
  EXPECT_EQ(warm.orders(), std::vector<int>{3});
  expect_same(warm.At({1.5}), stack.At({1.5, 55}));
  const OperatingPointModel near = stack.FixValues({4, std::nullopt});
  EXPECT_EQ(near.orders(), std::vector<int>{2});
  expect_same(near.At({22}), stack.At({4, 22}));
  const OperatingPointModel both = stack.FixValues({4, 22});
  EXPECT_TRUE(both.ranges().empty());
  expect_same(both.At({}), stack.At({4, 22}));
  expect_same(stack.SliceAlong(1).At({22}), stack.At({3, 22}));
}

TEST(OperatingPointModel, OneMoreTermDoesNotChangeIt) {
  const OperatingPointModel both = UnevenStackOfBoth();
  const OperatingPointModel more = both.AddOrder(1);
  EXPECT_EQ(more.orders(), (std::vector<int>{3, 3}));
  EXPECT_EQ(more.At({2, 57}).Parameters(), both.At({2, 57}).Parameters());
  EXPECT_EQ(more.terms()[1].points()[5], both.terms()[1].points()[5]);
  EXPECT_EQ(more.terms()[5].points()[5], both.terms()[5].points()[5]);
}

TEST(OperatingPointGrid, DerivativesAreThoseOfBothConditions) {
  const OperatingPointGrid camera(UnevenStackOfBoth(), {2.5, 51});
  ExpectRoundTrip(camera, 1e-6);
  ExpectDerivativeByPoint(camera, 1e-6);
  ExpectDerivativeByParameter(camera, 1e-5, 1e-5);
}

}  // namespace
}  // namespace raygrid
