#include "camera/view_camera.h"

#include <opencv2/calib3d.hpp>

#include "support.h"

namespace raygrid {
namespace {

constexpr ViewProjection kProjections[] = {
    ViewProjection::kPinhole, ViewProjection::kCylindrical,
    ViewProjection::kEquirectangular, ViewProjection::kStereographic,
    ViewProjection::kEquidistant};

ViewCamera ViewOfProjection(ViewProjection projection) {
  const ImageSize size = {640, 480};
  return ViewCamera(projection, size, WholeImage(size), {220, 230, 320, 230});
}

TEST(ViewCamera, ProjectionInvertsUnprojection) {
  for (const ViewProjection projection : kProjections)
    ExpectRoundTrip(ViewOfProjection(projection), 1e-9);
}

TEST(ViewCamera, DerivativesAreThoseOfProjection) {
  for (const ViewProjection projection : kProjections) {
    ExpectDerivativeByPoint(ViewOfProjection(projection), 1e-5);
    ExpectDerivativeByParameter(ViewOfProjection(projection), 1e-5, 1e-6);
  }
}

TEST(ViewCamera, EquidistantOneIsOpenCvsFisheye) {
  const ViewCamera view = ViewOfProjection(ViewProjection::kEquidistant);
  TestRandom random(1);
  for (int k = 0; k < 100; ++k) {
    const cv::Point3d point(random.Uniform(-1, 1), random.Uniform(-1, 1), 1);
    std::vector<cv::Point2d> pixels;
    cv::fisheye::projectPoints(std::vector<cv::Point3d>{point}, pixels,
                               cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0),
                               cv::Matx33d(220, 0, 320, 0, 230, 230, 0, 0, 1),
                               cv::Vec4d(0, 0, 0, 0));
    EXPECT_LT((*view.Project({point.x, point.y, point.z}) -
               Eigen::Vector2d(pixels[0].x, pixels[0].y))
                  .norm(),
              1e-9);
  }
}

// A direction 60 degrees to the right and 45 degrees up is seen here, in
// radians and in the plane's tangents, worked out by hand.
TEST(ViewCamera, ShowsADirectionWhereItsProjectionSays) {
  const double across = std::cos(M_PI / 4);
  const Eigen::Vector3d direction(across * std::sin(M_PI / 3), -std::sqrt(0.5),
                                  across / 2);
  const double theta = std::acos(std::sqrt(1.0 / 8));
  const Eigen::Vector2d side(std::sqrt(3.0 / 7), -std::sqrt(4.0 / 7));
  const Eigen::Vector2d expected[] = {{std::sqrt(3), -2},
                                      {M_PI / 3, -1},
                                      {M_PI / 3, -M_PI / 4},
                                      2 * std::tan(theta / 2) * side,
                                      theta * side};
  for (const ViewProjection projection : kProjections)
    EXPECT_LT((PlanePoint(projection, direction) -
               expected[static_cast<int>(projection)])
                  .norm(),
              1e-12)
        << ProjectionName(projection);
}

TEST(ViewCamera, ShowsNothingBeyondWhereItsProjectionEnds) {
  const Eigen::Vector3d behind(0, 0, -1), above(0, -1, 0);
  for (const ViewProjection projection : kProjections) {
    const bool is_around = projection == ViewProjection::kCylindrical ||
                           projection == ViewProjection::kEquirectangular;
    EXPECT_EQ(ContainsDirection(projection, behind), is_around);
    EXPECT_EQ(ContainsDirection(projection, above),
              !is_around && projection != ViewProjection::kPinhole);
    EXPECT_FALSE(ContainsDirection(projection, Eigen::Vector3d::Zero()));
    EXPECT_FALSE(ViewOfProjection(projection).Project({NAN, 0, 1}))
        << ProjectionName(projection);
    EXPECT_EQ(PlaneDirection(projection, {3.2, 0}).has_value(),
              projection == ViewProjection::kPinhole ||
                  projection == ViewProjection::kStereographic);
  }
  EXPECT_TRUE(PlaneDirection(ViewProjection::kCylindrical, {3.1, 9}));
  EXPECT_FALSE(PlaneDirection(ViewProjection::kEquirectangular, {0, 1.6}));
  EXPECT_FALSE(PlaneDirection(ViewProjection::kEquidistant, {2.3, 2.3}));
}

TEST(ViewCamera, NamesOfProjectionsComeBack) {
  for (const ViewProjection projection : kProjections)
    EXPECT_EQ(FindProjection(ProjectionName(projection)), projection);
  EXPECT_FALSE(FindProjection("orthographic"));
}

}  // namespace
}  // namespace raygrid
