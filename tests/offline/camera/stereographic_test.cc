#include "camera/stereographic.h"

#include "support.h"

namespace raygrid {
namespace {

// Random directions up to an angle from the z axis.
std::vector<Eigen::Vector3d> Directions(double max_angle_deg) {
  TestRandom random(1);
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < 500; ++i) {
    const double theta = random.Uniform(0, max_angle_deg) * M_PI / 180;
    const double phi = random.Uniform(0, 2 * M_PI);
    directions.emplace_back(std::sin(theta) * std::cos(phi),
                            std::sin(theta) * std::sin(phi), std::cos(theta));
  }
  directions.emplace_back(0, 0, 1);
  return directions;
}

TEST(Stereographic, FromChartInvertsToChartUpTo150Degrees) {
  for (const Eigen::Vector3d& direction : Directions(150))
    EXPECT_LT((FromChart(ToChart(7.5 * direction)) - direction).norm(), 1e-13);
}

TEST(Stereographic, ToChartInvertsFromChart) {
  TestRandom random(2);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d chart = 3 * random.NormalVector<2>();
    EXPECT_LT((ToChart(FromChart(chart)) - chart).norm(),
              1e-12 * (1 + chart.squaredNorm()));
    EXPECT_NEAR(FromChart(chart).norm(), 1, 1e-14);
  }
}

TEST(Stereographic, ChartRadiusIsTheTangentOfHalfTheAngle) {
  for (const Eigen::Vector3d& direction : Directions(150)) {
    const double theta = std::atan2(direction.head<2>().norm(), direction.z());
    EXPECT_NEAR(ToChart(direction).norm(), std::tan(theta / 2), 1e-12);
  }
}

TEST(Stereographic, ToChartDerivativeIsThatOfToChart) {
  const auto chart = [](const Eigen::VectorXd& d) -> Eigen::VectorXd {
    return ToChart(d);
  };
  for (const Eigen::Vector3d& direction : Directions(150)) {
    const Eigen::Vector3d scaled = 1.7 * direction;
    EXPECT_LT(RelativeDifference(ToChartDerivative(scaled),
                                 CentralDifference(chart, scaled, 1e-6)),
              1e-7);
  }
}

TEST(Stereographic, RotationDerivativeIsThatOfARotatedDirection) {
  for (const Eigen::Vector3d& direction : Directions(140)) {
    const auto rotated = [&](const Eigen::VectorXd& r) -> Eigen::VectorXd {
      return ToChart(RotationFromVector(r) * direction);
    };
    EXPECT_LT(RelativeDifference(
                  ChartRotationDerivative(ToChart(direction)),
                  CentralDifference(rotated, Eigen::Vector3d::Zero(), 1e-6)),
              1e-7);
  }
}

}  // namespace
}  // namespace raygrid
