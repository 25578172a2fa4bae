#include "camera/central_generic.h"

#include "simulation/simulated_camera.h"
#include "support.h"

namespace raygrid {
namespace {

CentralGeneric ExampleGrid() {
  return FittedGrid(ExampleSimulatedCamera(), 40);
}

TEST(CentralGeneric, ProjectionInvertsUnprojection) {
  ExpectRoundTrip(ExampleGrid(), 1e-6);
}

TEST(CentralGeneric, ProjectionInvertsUnprojectionBeyond90DegreesOffAxis) {
  const CentralGeneric fisheye = ExampleFisheye();
  ASSERT_LT(fisheye.Unproject({2, 400})->z(), 0);
  ExpectRoundTrip(fisheye, 1e-6);
}

TEST(CentralGeneric, ProjectionDoesNotDependOnItsStart) {
  const CentralGeneric camera = ExampleGrid();
  TestRandom random(1);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(camera.area());
    const Eigen::Vector2d start = random.PixelIn(camera.area());
    const auto projection = camera.Project(*camera.Unproject(pixel), &start, 0);
    ASSERT_TRUE(projection);
    EXPECT_LT((*projection - pixel).norm(), 1e-6);
  }
}

TEST(CentralGeneric, ProjectsNothingIntoAFold) {
  for (const double radius_px : {380.0, 200.0})
    for (const double mirror : {1.0, -1.0})
      ExpectProjectionIntoFold(FoldedFisheye(radius_px, mirror), radius_px);
}

TEST(CentralGeneric, SeesNothingOutsideItsArea) {
  const CentralGeneric camera = ExampleGrid();
  const Area& area = camera.area();
  for (const double outside : {0.001, 1.0, 100.0}) {
    EXPECT_FALSE(camera.Unproject({area.x0 - outside, 100}));
    EXPECT_FALSE(camera.Unproject({area.x1 + outside, 100}));
    EXPECT_FALSE(camera.Unproject({100, area.y0 - outside}));
    EXPECT_FALSE(camera.Unproject({100, area.y1 + outside}));
  }
  EXPECT_FALSE(camera.Unproject({NAN, 100}));
}

TEST(CentralGeneric, ProjectsNothingThatIsSeenOutsideItsArea) {
  const SimulatedCamera truth = ExampleSimulatedCamera();
  const Area inner = {100, 80, 500, 400};
  const CentralGeneric camera = FitCentralGeneric(truth, inner, 13, 11);
  TestRandom random(2);
  int num_outside = 0;
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(truth.area());
    const bool inside = inner.Contains(pixel, -0.01);
    if (!inside && inner.Contains(pixel, 0.01)) continue;
    num_outside += !inside;
    EXPECT_EQ(camera.Project(*truth.Unproject(pixel)).has_value(), inside)
        << pixel.transpose();
  }
  EXPECT_GT(num_outside, 100);
}

TEST(CentralGeneric, ProjectsNothingFromBehind) {
  const CentralGeneric camera = ExampleGrid();
  EXPECT_FALSE(camera.Project({0, 0, -1}));
  EXPECT_FALSE(camera.Project({0.1, 0.2, -1}));
  EXPECT_FALSE(camera.Project({0, 0, 0}));
  EXPECT_FALSE(camera.Project({NAN, 0, 1}));
}

TEST(CentralGeneric, MarginLetsProjectionsLieALittleOutside) {
  const SimulatedCamera truth = ExampleSimulatedCamera();
  const CentralGeneric camera =
      FitCentralGeneric(truth, {100, 80, 500, 400}, 13, 11);
  const Eigen::Vector2d pixel(502, 200);
  const Eigen::Vector3d ray = *truth.Unproject(pixel);
  EXPECT_FALSE(camera.Project(ray, nullptr, 1));
  const auto projection = camera.Project(ray, nullptr, 3);
  ASSERT_TRUE(projection);
  EXPECT_LT((*projection - pixel).norm(), 0.05);
}

TEST(CentralGeneric, DerivativeByPointIsThatOfProjection) {
  ExpectDerivativeByPoint(ExampleGrid(), 1e-6);
  ExpectDerivativeByPoint(ExampleFisheye(), 1e-6);
}

TEST(CentralGeneric, DerivativeByParametersIsThatOfProjection) {
  ExpectDerivativeByParameter(ExampleGrid(), 1e-5, 1e-5);
}

TEST(CentralGeneric, ParametersSetAreParametersGot) {
  CentralGeneric camera = ExampleGrid();
  const Eigen::VectorXd parameters = 0.5 * camera.Parameters();
  camera.SetParameters(parameters);
  EXPECT_EQ(camera.Parameters(), parameters);
  EXPECT_EQ(camera.NumParameters(), 2 * camera.surface().num_points());
}

TEST(FitCentralGeneric, FollowsASmoothModelTheCloserTheFinerTheCells) {
  const SimulatedCamera truth = ExampleSimulatedCamera();
  double worst[2] = {0, 0};
  TestRandom random(3);
  const CentralGeneric grids[2] = {FittedGrid(truth, 80),
                                   FittedGrid(truth, 20)};
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(truth.area());
    const Eigen::Vector3d ray = *truth.Unproject(pixel);
    for (int g = 0; g < 2; ++g)
      worst[g] = std::max(worst[g],
                          (*grids[g].Project(ray, &pixel, 3) - pixel).norm());
  }
  EXPECT_LT(worst[0], 0.2);
  EXPECT_LT(worst[1], 1e-3);
}

}  // namespace
}  // namespace raygrid
