#include "camera/model_fitting.h"
#include "simulation/asymmetric_camera.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr ImageSize kUnevenSize = {640, 480};
constexpr double kMiddleX = 319.5, kMiddleY = 239.5;

class UnevenLensOf : public testing::TestWithParam<const char*> {
 protected:
  std::unique_ptr<CameraModel> lens_ =
      MakeSimulatedCamera(GetParam(), kUnevenSize);
};

TEST_P(UnevenLensOf, ProjectionInvertsUnprojection) {
  ExpectRoundTrip(*lens_, 1e-8);
}

TEST_P(UnevenLensOf, DerivativeByPointIsThatOfProjection) {
  ExpectDerivativeByPoint(*lens_, 1e-5);
}

TEST_P(UnevenLensOf, SeesTheSameInAnImageOfAnotherSize) {
  const auto large = MakeSimulatedCamera(GetParam(), {1280, 960});
  const Eigen::Vector2d offset(100, -70);
  const Eigen::Vector3d small_ray =
      lens_->Unproject(Eigen::Vector2d(kMiddleX, kMiddleY) + offset).value();
  const Eigen::Vector3d large_ray =
      large->Unproject(Eigen::Vector2d(639.5, 479.5) + 2 * offset).value();
  EXPECT_LT((small_ray - large_ray).norm(), 1e-12);
}

// Each model as near as it comes.
TEST_P(UnevenLensOf, IsFollowedByNoRadialLens) {
  for (const char* model : {"central-radial", "thin-prism-fisheye", "opencv"}) {
    const FittedModel fit =
        FitNearestModel(model, *lens_, WholeImage(kUnevenSize));
    double largest_px = 0;
    for (int row = 0; row <= 30; ++row) {
      for (int column = 0; column <= 40; ++column) {
        const Eigen::Vector2d pixel(column * 639 / 40.0, row * 479 / 30.0);
        const auto seen = fit.model->Project(
            fit.model_from_camera * lens_->Unproject(pixel).value(), nullptr,
            1e9);
        largest_px =
            std::max(largest_px, seen ? (*seen - pixel).norm() : INFINITY);
      }
    }
    EXPECT_GT(largest_px, 20) << model;
  }
}

INSTANTIATE_TEST_SUITE_P(Lenses, UnevenLensOf,
                         testing::Values("anamorphic", "off-axis", "halves",
                                         "decentred", "mirror"));

TEST(AnamorphicCamera, HasTwiceTheFocalLengthVertically) {
  const auto lens = MakeSimulatedCamera("anamorphic", kUnevenSize);
  LinearizedProjection center;
  ASSERT_TRUE(lens->Linearize({0, 0, 1}, nullptr, 0, &center));
  EXPECT_NEAR(center.J_point(1, 1) / center.J_point(0, 0), 2, 1e-6);
}

TEST(OffAxisCamera, LooksAlongItsAxisAThirdOfTheImageFromTheMiddle) {
  const auto lens = MakeSimulatedCamera("off-axis", kUnevenSize);
  const Eigen::Vector2d axis = lens->Project({0, 0, 1}).value();
  EXPECT_NEAR(axis.x() - kMiddleX, 640 / 3.0, 1e-9);
}

TEST(TwoFocalLengthsCamera, HasTwiceTheFocalLengthOnTheRight) {
  const auto lens = MakeSimulatedCamera("halves", kUnevenSize);
  const auto height_at = [&](double x) {
    const Eigen::Vector3d ray = lens->Unproject({x, kMiddleY + 100}).value();
    return ray.y() / ray.z();
  };
  EXPECT_NEAR(height_at(0) / height_at(639), 2, 1e-3);
}

// From the mirror's second focus, the points of a hyperboloid that reflect what
// a line of pixels sees lie in a plane: a camera there has no distortion.
TEST(MirrorCamera, SeesWhatAHyperboloidReflects) {
  constexpr double kXi = 0.98;         // 2 e / (1 + e^2)
  constexpr double kParameter = 0.03;  // metres
  const double eccentricity = (1 + std::sqrt(1 - kXi * kXi)) / kXi;
  const double foci_m =
      2 * eccentricity * kParameter / (eccentricity * eccentricity - 1);
  const auto lens = MakeSimulatedCamera("mirror", kUnevenSize);
  const auto reflected = [&](const Eigen::Vector2d& pixel) {
    // The hyperbola in polar coordinates around its first focus.
    const Eigen::Vector3d ray = lens->Unproject(pixel).value();
    const double distance_m = kParameter / (1 + eccentricity * ray.z());
    EXPECT_GT(distance_m, 0);
    Eigen::Vector3d from_second = distance_m * ray;
    from_second.z() -= foci_m;
    return from_second.normalized();
  };
  TestRandom random(4);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d a = random.PixelIn(WholeImage(kUnevenSize));
    const Eigen::Vector2d b = random.PixelIn(WholeImage(kUnevenSize));
    const Eigen::Vector3d normal = reflected(a).cross(reflected(b));
    EXPECT_LT(std::abs(normal.dot(reflected(a + 0.4 * (b - a)))), 1e-12);
  }
}

}  // namespace
}  // namespace raygrid
