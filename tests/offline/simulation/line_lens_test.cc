#include "evaluation/noncentrality.h"
#include "simulation/noncentral_simulated_camera.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr ImageSize kLinesSize = {320, 240};

TEST(CoverGlassCamera, DisplacesLinesAsSnellSaysAndDoesNotTurnThem) {
  const auto pinhole = MakeSimulatedCamera("pinhole", kLinesSize);
  GlassPlate plate;
  plate.tilt_rad = 0.4;
  const CoverGlassCamera lens(*pinhole, plate);
  const Eigen::Vector3d normal(std::sin(0.4), 0, std::cos(0.4));
  TestRandom random(1);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(WholeImage(kLinesSize));
    const ObservationLine line = lens.Line(pixel).value();
    const Eigen::Vector3d direction = pinhole->Unproject(pixel).value();
    EXPECT_EQ(line.direction, direction);
    // The textbook's displacement by a plate.
    const double in = std::acos(normal.dot(direction));
    const double inside = std::asin(std::sin(in) / plate.refractive_index);
    const double displacement =
        plate.thickness_m * std::sin(in - inside) / std::cos(inside);
    EXPECT_NEAR(line.origin.cross(direction).norm(), displacement, 1e-12);
    // It starts on the second face.
    EXPECT_NEAR(normal.dot(line.origin),
                normal.z() * plate.distance_m + plate.thickness_m, 1e-12);
  }
}

TEST(CoverGlassCamera, ThinAirDoesNothing) {
  GlassPlate air;
  air.refractive_index = 1;
  const auto pinhole = MakeSimulatedCamera("pinhole", kLinesSize);
  const CoverGlassCamera lens(*pinhole, air);
  EXPECT_LT(ComputeNoncentrality(lens).max_m, 1e-12);
}

TEST(NoncentralSimulatedCamera, ProjectionInvertsLines) {
  for (const char* name : {"glass", "noncentral"}) {
    const auto lens = MakeSimulatedCamera(name, kLinesSize);
    EXPECT_FALSE(lens->IsCentral());
    TestRandom random(2);
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector2d pixel = random.PixelIn(WholeImage(kLinesSize));
      const auto found = lens->Project(
          PointAlong(lens->Line(pixel).value(), random.Uniform(0.1, 1)));
      ASSERT_TRUE(found) << name << " " << pixel.transpose();
      EXPECT_LT((*found - pixel).norm(), 1e-6);
    }
  }
}

TEST(NoncentralSimulatedCamera, DerivativeByPointIsThatOfProjection) {
  const auto lens = MakeSimulatedCamera("glass", kLinesSize);
  TestRandom random(3);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(WholeImage(kLinesSize));
    const Eigen::Vector3d point = PointAlong(lens->Line(pixel).value(), 0.4);
    LinearizedProjection linear;
    ASSERT_TRUE(lens->Linearize(point, nullptr, 0, &linear));
    const auto project = [&](const Eigen::VectorXd& p) -> Eigen::VectorXd {
      return lens->Project(p, &pixel, 0).value();
    };
    EXPECT_LT(RelativeDifference(linear.J_point,
                                 CentralDifference(project, point, 1e-5)),
              1e-4);
  }
}

TEST(Noncentrality, OfACentralCameraIsZero) {
  const Noncentrality spread = ComputeNoncentrality(ExampleLens());
  EXPECT_EQ(spread.max_m, 0);
  EXPECT_EQ(spread.nearest_point, Eigen::Vector3d::Zero());
}

TEST(Noncentrality, FindsThePointWhereAllLinesMeet) {
  const Eigen::Vector3d point(0.001, -0.002, 0.005);
  const Noncentrality spread = ComputeNoncentrality(
      NonCentralGeneric(MakeCentral(ExampleLines())).WithOrigin(-point));
  EXPECT_LT((spread.nearest_point - point).norm(), 1e-9);
  EXPECT_LT(spread.max_m, 1e-9);
}

TEST(Noncentrality, OfTwistedLinesIsTheTwist) {
  const CentralGeneric directions = MakeCentral(ExampleLines());
  NonCentralGeneric camera(directions);
  Eigen::VectorXd parameters = camera.Parameters();
  // A twist about the z axis: no point is nearer to all.
  constexpr double kTwist = 0.002;
  for (Eigen::Index k = 0; k < parameters.size(); k += 5)
    parameters.segment<3>(k + 2) << -kTwist * parameters[k + 1],
        kTwist * parameters[k], 0;
  camera.SetParameters(parameters);
  const Noncentrality spread = ComputeNoncentrality(camera);
  double largest = 0;
  for (const double x : {0.0, 639.0})
    for (const double y : {0.0, 479.0}) {
      const Eigen::Vector3d d = *directions.Unproject({x, y});
      largest = std::max(largest, kTwist * std::tan(std::acos(d.z()) / 2));
    }
  EXPECT_LT(spread.nearest_point.norm(), 0.1 * kTwist);
  EXPECT_NEAR(spread.max_m, largest, 0.1 * largest);
  EXPECT_GT(spread.rms_m, 0.4 * spread.max_m);
  EXPECT_LT(spread.rms_m, spread.max_m);
}

}  // namespace
}  // namespace raygrid
