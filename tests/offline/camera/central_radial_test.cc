#include "camera/central_radial.h"

#include "camera/thin_prism_fisheye.h"
#include "support.h"

namespace raygrid {
namespace {

const ImageSize kRadialSize = {800, 800};

// A waving radial factor; its corners look 110 degrees off axis.
CentralRadial ExampleRadial(int num_parameters = 12) {
  std::vector<double> spline;
  for (int k = 1; k <= num_parameters; ++k) {
    const double theta = 2.2 * k / (num_parameters - 1);
    spline.push_back(0.02 * theta * theta + 0.02 * std::sin(4 * theta));
  }
  return CentralRadial(kRadialSize, WholeImage(kRadialSize), 2.2, spline,
                       {280, 282, 402, 396, 1e-3, -8e-4, 6e-4, -5e-4});
}

TEST(CentralRadial, ProjectionInvertsUnprojection) {
  ExpectRoundTrip(ExampleRadial(), 1e-6);
  ExpectRoundTrip(ExampleRadial(30), 1e-6);
}

TEST(CentralRadial, DerivativeByPointIsThatOfProjection) {
  ExpectDerivativeByPoint(ExampleRadial(), 1e-6);
}

TEST(CentralRadial, DerivativeByParametersIsThatOfProjection) {
  ExpectDerivativeByParameter(ExampleRadial(), 1e-5, 1e-6);
}

// A parabola is a cubic spline: theta^2 at the points (k^2 - 1/3) h^2.
TEST(CentralRadial, IsAThinPrismFisheyeWhereItsFactorIsAParabola) {
  const double k1 = 0.03, h = 2.2 / 9;
  std::vector<double> spline;
  for (int k = 1; k <= 10; ++k)
    spline.push_back(k1 * (k * k - 1.0 / 3) * h * h);
  // g(0) = 0 needs s_0 = -s_1 / 2, which the parabola has.
  ASSERT_NEAR(-k1 / 3 * h * h, -spline[0] / 2, 1e-15);
  const CentralRadial radial(kRadialSize, WholeImage(kRadialSize), 2.2, spline,
                             {280, 282, 402, 396, 1e-3, -8e-4, 6e-4, -5e-4});
  const ThinPrismFisheye fisheye(
      kRadialSize, WholeImage(kRadialSize),
      {280, 282, 402, 396, k1, 0, 0, 0, 1e-3, -8e-4, 6e-4, -5e-4});
  TestRandom random(3);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(WholeImage(kRadialSize));
    EXPECT_LT((*radial.Unproject(pixel) - *fisheye.Unproject(pixel)).norm(),
              1e-9);
  }
}

TEST(CentralRadial, FocalLengthsAreThoseOfTheCentre) {
  LinearizedProjection linear;
  ASSERT_TRUE(ExampleRadial().Linearize({0, 0, 2}, nullptr, 0, &linear));
  EXPECT_NEAR(linear.J_point(0, 0), 280 / 2.0, 1e-9);
  EXPECT_NEAR(linear.J_point(1, 1), 282 / 2.0, 1e-9);
}

TEST(CentralRadial, EndsWithItsSpline) {
  const CentralRadial lens(kRadialSize, WholeImage(kRadialSize), 1,
                           {0, 0, 0, 0}, {200, 200, 400, 400, 0, 0, 0, 0});
  const auto at = [](double theta) {
    return Eigen::Vector3d(std::sin(theta), 0, std::cos(theta));
  };
  EXPECT_TRUE(lens.Project(at(0.99)));
  EXPECT_FALSE(lens.Project(at(1.01)));
  EXPECT_TRUE(lens.Unproject({400 + 199, 400}));
  EXPECT_FALSE(lens.Unproject({400 + 201, 400}));
}

TEST(CentralRadial, EndsWhereItFolds) {
  // g falls to 0 by the spline's end.
  CentralRadial lens(kRadialSize, WholeImage(kRadialSize), 2,
                     {-0.25, -0.5, -0.75, -1, -1.25},
                     {200, 200, 400, 400, 0, 0, 0, 0});
  EXPECT_TRUE(lens.Project({0.3, 0, 1}));
  EXPECT_FALSE(lens.Project({1, 0, -0.2}));
}

}  // namespace
}  // namespace raygrid
