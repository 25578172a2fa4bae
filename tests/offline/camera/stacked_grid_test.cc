#include "camera/stacked_grid.h"

#include "support.h"

namespace raygrid {
namespace {

// A lens that changes by some pixels, and all over the place.
CameraStack UnevenStack() {
  CameraStack stack(
      CameraCondition::kLensPosition, 1, 5,
      FitCentralGeneric(ExampleSimulatedCamera(), {0, 0, 639, 479}, 9, 8), 3);
  TestRandom random(3);
  for (int j = 1; j <= stack.order(); ++j)
    for (Eigen::Vector2d& point : stack.terms()[j].points())
      point = 2e-3 * random.NormalVector<2>();
  return stack;
}

TEST(CameraStack, IsItsFirstTermInTheMiddle) {
  const CameraStack stack = UnevenStack();
  EXPECT_EQ(stack.At(3).Parameters(),
            CentralGeneric({640, 480}, stack.terms()[0]).Parameters());
}

TEST(CameraStack, IsAPolynomialOfTheCondition) {
  const CameraStack stack = UnevenStack();
  // t is -1 at 1, 1 at 5, and 1/2 at 4.
  for (const auto& [value, t] :
       {std::pair(1.0, -1.0), std::pair(5.0, 1.0), std::pair(4.0, 0.5)}) {
    const Eigen::Vector2d expected =
        stack.terms()[0].points()[20] +
        t * (stack.terms()[1].points()[20] +
             t * (stack.terms()[2].points()[20] +
                  t * stack.terms()[3].points()[20]));
    EXPECT_LT((stack.At(value).surface().points()[20] - expected).norm(),
              1e-15);
  }
}

TEST(StackedGrid, SeesAsTheCameraAtItsValue) {
  const CameraStack stack = UnevenStack();
  StackedGrid camera(stack, 2);
  ExpectRoundTrip(camera, 1e-6);
  const Eigen::Vector2d pixel(100, 300);
  EXPECT_EQ(*camera.Unproject(pixel), *stack.At(2).Unproject(pixel));
  camera.SetValue(4.5);
  EXPECT_EQ(*camera.Unproject(pixel), *stack.At(4.5).Unproject(pixel));
}

TEST(StackedGrid, DerivativesAreThoseOfProjection) {
  for (const double value : {1.0, 2.5, 4.9}) {
    const StackedGrid camera(UnevenStack(), value);
    ExpectDerivativeByPoint(camera, 1e-6);
    ExpectDerivativeByParameter(camera, 1e-5, 1e-5);
  }
}

TEST(StackedGrid, ParametersAreThoseOfTheWholeStack) {
  const StackedGrid camera(UnevenStack(), 2);
  StackedGrid other(
      CameraStack(CameraCondition::kLensPosition, 1, 5,
                  CentralGeneric({640, 480}, camera.stack().terms()[1]), 3),
      4);
  other.SetParameters(camera.Parameters());
  EXPECT_EQ(other.Parameters(), camera.Parameters());
  EXPECT_EQ(other.stack().At(2).Parameters(), camera.camera().Parameters());
  EXPECT_EQ(other.value(), 4);
}

}  // namespace
}  // namespace raygrid
