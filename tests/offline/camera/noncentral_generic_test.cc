#include "camera/noncentral_generic.h"

#include "support.h"

namespace raygrid {
namespace {

// Millimetres of disorder in the points.
NonCentralGeneric UnevenLines() {
  NonCentralGeneric camera = ExampleLines();
  TestRandom random(5);
  Eigen::VectorXd parameters = camera.Parameters();
  for (Eigen::Index k = 0; k < parameters.size(); k += 5)
    parameters.segment<3>(k + 2) += 1e-3 * random.NormalVector<3>();
  camera.SetParameters(parameters);
  return camera;
}

TEST(NonCentralGeneric, ProjectionInvertsLines) {
  ExpectRoundTrip(ExampleLines(), 1e-6);
  ExpectRoundTrip(UnevenLines(), 1e-6);
}

TEST(NonCentralGeneric, ProjectionDoesNotDependOnItsStart) {
  const NonCentralGeneric camera = UnevenLines();
  TestRandom random(1);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(camera.area());
    const Eigen::Vector2d start = random.PixelIn(camera.area());
    const auto projection =
        camera.Project(PointAlong(*camera.Line(pixel), 0.3), &start, 0);
    ASSERT_TRUE(projection);
    EXPECT_LT((*projection - pixel).norm(), 1e-6);
  }
}

TEST(NonCentralGeneric, ProjectsNothingIntoAFold) {
  for (const double radius_px : {380.0, 200.0})
    for (const double mirror : {1.0, -1.0})
      ExpectProjectionIntoFold(
          NonCentralGeneric(FoldedFisheye(radius_px, mirror)), radius_px);
}

TEST(NonCentralGeneric, DerivativeByPointIsThatOfProjection) {
  ExpectDerivativeByPoint(UnevenLines(), 1e-6);
}

TEST(NonCentralGeneric, DerivativeByParametersIsThatOfProjection) {
  ExpectDerivativeByParameter(UnevenLines(), 1e-5, 1e-5);
}

TEST(NonCentralGeneric, SeesNothingOutsideItsArea) {
  const NonCentralGeneric camera = ExampleLines();
  for (const double outside : {0.001, 1.0, 100.0}) {
    EXPECT_FALSE(camera.Line({-outside, 100}));
    EXPECT_FALSE(camera.Unproject({639 + outside, 100}));
    EXPECT_FALSE(camera.Line({100, 479 + outside}));
  }
  EXPECT_FALSE(camera.Line({NAN, 100}));
}

TEST(NonCentralGeneric, ProjectsNothingFromBehindOrNowhere) {
  const NonCentralGeneric camera = UnevenLines();
  TestRandom random(2);
  for (int i = 0; i < 100; ++i) {
    const ObservationLine line = *camera.Line(random.PixelIn(camera.area()));
    EXPECT_FALSE(camera.Project(PointAlong(line, -0.5)));
  }
  EXPECT_FALSE(camera.Project({NAN, 0, 1}));
  EXPECT_FALSE(camera.Project({0, 0, INFINITY}));
  EXPECT_FALSE(
      NonCentralGeneric(MakeCentral(camera)).Project(Eigen::Vector3d::Zero()));
}

TEST(NonCentralGeneric, WithAllPointsAtTheOriginIsCentral) {
  const CentralGeneric central = MakeCentral(ExampleLines());
  const NonCentralGeneric lines(central);
  TestRandom random(3);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(central.area());
    EXPECT_EQ(*lines.Unproject(pixel), *central.Unproject(pixel));
    EXPECT_EQ(lines.Line(pixel)->origin, Eigen::Vector3d::Zero());
    const Eigen::Vector3d point = 0.7 * *central.Unproject(pixel);
    EXPECT_LT((*lines.Project(point) - *central.Project(point)).norm(), 1e-9);
  }
}

TEST(NonCentralGeneric, AShiftOfAllPointsIsAShiftOfTheFrame) {
  const NonCentralGeneric camera = UnevenLines();
  const Eigen::Vector3d origin(0.003, -0.002, 0.01);
  const NonCentralGeneric moved = camera.WithOrigin(origin);
  TestRandom random(4);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(camera.area());
    const Eigen::Vector3d point = PointAlong(*camera.Line(pixel), 0.4);
    EXPECT_LT((*moved.Project(point - origin) - pixel).norm(), 1e-6);
  }
}

TEST(NonCentralGeneric, ParametersSetAreParametersGot) {
  NonCentralGeneric camera = ExampleLines();
  const Eigen::VectorXd parameters = 0.5 * camera.Parameters();
  camera.SetParameters(parameters);
  EXPECT_EQ(camera.Parameters(), parameters);
  EXPECT_EQ(camera.NumParameters(), 5 * camera.directions().num_points());
}

// How far lines are apart, at two distances.
double LineDifference(const ObservationLine& a, const ObservationLine& b) {
  double largest = 0;
  for (const double distance : {0.1, 1.0})
    largest = std::max(
        largest,
        (PointAlong(a, distance) - b.origin).cross(b.direction).norm());
  return largest;
}

TEST(FitNonCentralGeneric, FollowsTheLinesOfALens) {
  const auto lens = MakeSimulatedCamera("glass", {640, 480});
  const NonCentralGeneric fitted =
      FitNonCentralGeneric(*lens, WholeImage({640, 480}), 83, 63);
  TestRandom random(6);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(fitted.area());
    EXPECT_LT(LineDifference(*fitted.Line(pixel), *lens->Line(pixel)), 1e-6);
  }
}

}  // namespace
}  // namespace raygrid
