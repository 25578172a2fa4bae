#include "camera/camera_frame.h"

#include "camera/model_fitting.h"
#include "camera/rotated_camera.h"
#include "simulation/simulated_camera.h"
#include "support.h"

namespace raygrid {
namespace {

double AngleOf(const Eigen::Quaterniond& rotation) {
  return rotation.angularDistance(Eigen::Quaterniond::Identity());
}

CentralGeneric GridOf(const std::string& lens) {
  return FittedGrid(*MakeSimulatedCamera(lens, {640, 480}), 40);
}

TEST(CanonicalFrame, DoesNotDependOnHowTheCameraIsTurned) {
  for (const char* lens : {"example", "wide", "fisheye"}) {
    const CentralGeneric camera = GridOf(lens);
    const Eigen::Quaterniond frame =
        ComputeCanonicalFrame(camera).frame_from_camera;
    for (const Eigen::Vector3d& vector :
         {Eigen::Vector3d(0.1, -0.6, 0.05), Eigen::Vector3d(0, 0.01, 1),
          Eigen::Vector3d(-0.3, 0.3, 0)}) {
      const Eigen::Quaterniond turn = RotationFromVector(vector);
      const CanonicalFrame turned =
          ComputeCanonicalFrame(RotatedCamera(camera, turn));
      EXPECT_LT(AngleOf(turned.frame_from_camera * turn * frame.conjugate()),
                1e-6)
          << lens;
    }
  }
}

TEST(CanonicalFrame, OfALensIsTheLenssOwn) {
  const CanonicalFrame frame =
      ComputeCanonicalFrame(FittedGrid(ExampleLens(), 20));
  EXPECT_EQ(frame.lens, "opencv");
  EXPECT_LT(frame.AngleRad(), kMaxFrameRotationRad);
  EXPECT_EQ(ComputeCanonicalFrame(ExampleLens()).AngleRad(), 0);
}

// Least squares alone would turn the lens by degrees to follow the bumps.
TEST(CanonicalFrame, IsNotTurnedByBumps) {
  const CentralGeneric camera = GridOf("example");
  for (const std::string& lens : ListModelNames(ModelUse::kCompare))
    EXPECT_LT(ComputeCanonicalFrame(camera, lens).AngleRad(), 1 * M_PI / 180)
        << lens;
}

TEST(CanonicalFrame, OnceTurnedNeedsNoRotation) {
  const CentralGeneric camera = GridOf("example");
  const Eigen::Quaterniond astray = RotationFromVector({0.2, -0.5, 0.1});
  const auto off = Rotated(camera, astray);
  const CanonicalFrame frame = ComputeCanonicalFrame(*off);
  EXPECT_GT(frame.AngleRad(), 30 * M_PI / 180);
  const auto turned = Rotated(*off, frame.frame_from_camera);
  EXPECT_LT(ComputeCanonicalFrame(*turned).AngleRad(), kMaxFrameRotationRad);
  for (const std::string& lens : ListModelNames(ModelUse::kCompare))
    EXPECT_LT(
        AngleOf(
            FitNearestModel(lens, *turned, turned->area()).model_from_camera),
        kMaxFrameRotationRad)
        << lens;
}

TEST(Rotated, GridSeesTheSameRays) {
  const Eigen::Quaterniond turn = RotationFromVector({0.02, -0.3, 0.1});
  TestRandom random(5);
  const NonCentralGeneric lines = ExampleLines();
  const CentralGeneric grid = GridOf("example");
  for (const CameraModel* camera : {static_cast<const CameraModel*>(&grid),
                                    static_cast<const CameraModel*>(&lines)}) {
    const RotatedCamera exact(*camera, turn);
    const auto turned = Rotated(*camera, turn);
    EXPECT_EQ(turned->Name(), camera->Name());
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector2d pixel = random.PixelIn(camera->area());
      const ObservationLine line = exact.Line(pixel).value();
      const auto image = turned->Project(PointAlong(line, 1), &pixel, 1);
      ASSERT_TRUE(image);
      EXPECT_LT((*image - pixel).norm(), 1e-3);
      EXPECT_LT((*exact.Project(PointAlong(line, 2)) - pixel).norm(), 1e-6);
    }
  }
}

TEST(RotatedCamera, HasTheDerivativeByThePoint) {
  ExpectDerivativeByPoint(
      RotatedCamera(ExampleLines(), RotationFromVector({0.2, 0.1, -0.4})),
      1e-5);
}

}  // namespace
}  // namespace raygrid
