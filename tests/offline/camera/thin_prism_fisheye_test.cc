#include "camera/thin_prism_fisheye.h"

#include <opencv2/calib3d.hpp>

#include "support.h"

namespace raygrid {
namespace {

const ImageSize kPrismSize = {800, 800};

// Its corners look 115 degrees off axis; every coefficient at work.
ThinPrismFisheye ExamplePrism() {
  return ThinPrismFisheye(kPrismSize, WholeImage(kPrismSize),
                          {280, 282, 402, 396, 0.02, -0.01, 0.002, -1e-4, 1e-3,
                           -8e-4, 6e-4, -5e-4});
}

// theta (1 + k1 theta^2) folds at theta = 1 / sqrt(-3 k1).
ThinPrismFisheye FoldingPrism(double k1) {
  return ThinPrismFisheye(kPrismSize, WholeImage(kPrismSize),
                          {200, 200, 400, 400, k1, 0, 0, 0, 0, 0, 0, 0});
}

TEST(ThinPrismFisheye, SeesBehindItself) {
  const auto ray = ExamplePrism().Unproject({1, 1});
  ASSERT_TRUE(ray);
  EXPECT_LT(ray->z(), -0.3);
}

// The lens agrees with OpenCV's model where that has its coefficients and is
// valid.
TEST(ThinPrismFisheye, AgreesWithOpenCvsFisheye) {
  const ThinPrismFisheye lens(
      kPrismSize, WholeImage(kPrismSize),
      {280, 282, 402, 396, 0.02, -0.01, 0.002, -1e-4, 0, 0, 0, 0});
  TestRandom random(1);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d point(random.Uniform(-1, 1), random.Uniform(-1, 1),
                                random.Uniform(0.5, 3));
    const std::vector<cv::Point3d> points = {{point.x(), point.y(), point.z()}};
    std::vector<cv::Point2d> pixels;
    cv::fisheye::projectPoints(points, pixels, cv::Vec3d(0, 0, 0),
                               cv::Vec3d(0, 0, 0),
                               cv::Matx33d(280, 0, 402, 0, 282, 396, 0, 0, 1),
                               cv::Vec4d(0.02, -0.01, 0.002, -1e-4));
    const auto pixel = lens.Project(point);
    ASSERT_TRUE(pixel);
    EXPECT_LT((*pixel - Eigen::Vector2d(pixels[0].x, pixels[0].y)).norm(),
              1e-9);
  }
}

// Written out once more, from the header's equations.
TEST(ThinPrismFisheye, HasTangentialAndThinPrismTerms) {
  const Eigen::Vector3d point(0.4, -0.3, -0.02);
  const double theta = M_PI / 2 + std::atan(0.02 / 0.5);
  const double u = 0.8 * theta, v = -0.6 * theta, t2 = theta * theta;
  const double g = 1 + 0.02 * t2 - 0.01 * t2 * t2 + 0.002 * t2 * t2 * t2 -
                   1e-4 * t2 * t2 * t2 * t2;
  const double p1 = 1e-3, p2 = -8e-4;
  const Eigen::Vector2d expected(
      402 + 280 * (u * g + 2 * p1 * u * v + p2 * (t2 + 2 * u * u) + 6e-4 * t2),
      396 + 282 * (v * g + p1 * (t2 + 2 * v * v) + 2 * p2 * u * v - 5e-4 * t2));
  EXPECT_LT((ExamplePrism().Project(point).value() - expected).norm(), 1e-9);
}

TEST(ThinPrismFisheye, IsSmoothOnItsAxis) {
  const ThinPrismFisheye lens = ExamplePrism();
  for (const double offset : {0.0, 1e-9, 0.9e-4, 1.1e-4}) {
    const Eigen::Vector3d point(offset, 0, 1);
    LinearizedProjection linear;
    ASSERT_TRUE(lens.Linearize(point, nullptr, 0, &linear));
    EXPECT_NEAR(linear.pixel.x(), 402 + 280 * offset, 1e-5);
    EXPECT_NEAR(linear.J_point(0, 0), 280, 0.2);
    EXPECT_NEAR(linear.J_point(1, 1), 282, 0.2);
  }
}

TEST(ThinPrismFisheye, EndsWhereItFolds) {
  const ThinPrismFisheye lens = FoldingPrism(-0.1);
  const double fold = 1 / std::sqrt(0.3);
  EXPECT_NEAR(lens.max_theta(), fold, 0.01);
  const auto at = [](double theta) {
    return Eigen::Vector3d(std::sin(theta), 0, std::cos(theta));
  };
  EXPECT_TRUE(lens.Project(at(fold - 0.02)));
  EXPECT_FALSE(lens.Project(at(fold + 0.02)));
  EXPECT_FALSE(lens.Project({0, 0, -1}));
  EXPECT_FALSE(lens.Project({0, 0, 0}));
  EXPECT_FALSE(lens.Project({NAN, 0, 1}));
  // The fold is 200 * 2/3 * 1.826 = 243 px from the centre.
  EXPECT_TRUE(lens.Unproject({400 + 235, 400}));
  EXPECT_FALSE(lens.Unproject({400 + 250, 400}));
}

}  // namespace
}  // namespace raygrid
