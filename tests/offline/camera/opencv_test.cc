#include "camera/opencv.h"

#include <opencv2/calib3d.hpp>

#include "support.h"

namespace raygrid {
namespace {

// OpenCV's projection of a point with the same parameters.
Eigen::Vector2d ProjectByOpenCv(const Eigen::VectorXd& p,
                                const Eigen::Vector3d& point) {
  const cv::Matx33d matrix(p[OpenCvModel::kFx], 0, p[OpenCvModel::kCx],  //
                           0, p[OpenCvModel::kFy], p[OpenCvModel::kCy],  //
                           0, 0, 1);
  const std::vector<double> distortion = {
      p[OpenCvModel::kK1], p[OpenCvModel::kK2], p[OpenCvModel::kP1],
      p[OpenCvModel::kP2], p[OpenCvModel::kK3], p[OpenCvModel::kK4],
      p[OpenCvModel::kK5], p[OpenCvModel::kK6]};
  const std::vector<cv::Point3d> points = {{point.x(), point.y(), point.z()}};
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(points, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), matrix,
                    distortion, pixels);
  return {pixels[0].x, pixels[0].y};
}

// Barrel distortion that folds at r = 1 / sqrt(-3 k1).
OpenCvModel FoldingLens(double k1) {
  const ImageSize size = {640, 480};
  return OpenCvModel(size, WholeImage(size),
                     {300, 300, 320, 240, k1, 0, 0, 0, 0, 0, 0, 0});
}

TEST(OpenCvModel, ProjectionInvertsUnprojection) {
  ExpectRoundTrip(ExampleLens(), 1e-6);
}

TEST(OpenCvModel, AgreesWithOpenCv) {
  const OpenCvModel lens = ExampleLens();
  TestRandom random(1);
  int num_seen = 0;
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d point(random.Uniform(-1, 1), random.Uniform(-1, 1),
                                random.Uniform(0.5, 3));
    const auto pixel = lens.Project(point);
    if (!pixel) continue;
    ++num_seen;
    EXPECT_LT((*pixel - ProjectByOpenCv(lens.Parameters(), point)).norm(),
              1e-9);
  }
  EXPECT_GT(num_seen, 300);
}

TEST(OpenCvModel, DerivativeByPointIsThatOfProjection) {
  ExpectDerivativeByPoint(ExampleLens(), 1e-6);
}

TEST(OpenCvModel, DerivativeByParametersIsThatOfProjection) {
  ExpectDerivativeByParameter(ExampleLens(), 1e-5, 1e-6);
}

TEST(OpenCvModel, ProjectsNothingFromBehind) {
  const OpenCvModel lens = ExampleLens();
  EXPECT_TRUE(lens.Project({0, 0, 1}));
  EXPECT_FALSE(lens.Project({0, 0, -1}));
  EXPECT_FALSE(lens.Project({0.1, 0.1, -1}));
  EXPECT_FALSE(lens.Project({0.1, 0.1, 0}));
  EXPECT_FALSE(lens.Project({0, 0, 0}));
  EXPECT_FALSE(lens.Project({NAN, 0, 1}));
}

TEST(OpenCvModel, ProjectsNothingBeyondItsFold) {
  const OpenCvModel lens = FoldingLens(-0.5);
  const double fold = 1 / std::sqrt(1.5);
  EXPECT_TRUE(lens.Project({fold - 0.02, 0, 1}));
  // These would land within the image, where others are seen.
  EXPECT_FALSE(lens.Project({fold + 0.02, 0, 1}));
  EXPECT_FALSE(lens.Project({0, -1.2, 1}));
  EXPECT_FALSE(lens.Project({1.4, 0, 1}));
}

TEST(OpenCvModel, UnprojectsNothingThatNoDirectionReaches) {
  const OpenCvModel lens = FoldingLens(-0.5);
  // The fold is 300 * 2/3 * 0.816 = 163 px from the centre.
  EXPECT_TRUE(lens.Unproject({320 + 155, 240}));
  EXPECT_FALSE(lens.Unproject({320 + 170, 240}));
  EXPECT_FALSE(lens.Unproject({0, 0}));
}

// Numerator and denominator nearly cancel, but for a bump of the distortion
// that is a few pixels wide. Newton's method went astray at 263 of these
// pixels.
TEST(OpenCvModel, UnprojectsBesideANarrowBump) {
  const ImageSize size = {1280, 960};
  const OpenCvModel lens(size, WholeImage(size),
                         {1800, 1800, 639.5, 479.5, -33.203632, 276.496937, 0,
                          -33.233632, 276.946937, 0, 0.002, -0.001});
  int num_without = 0;
  for (int y = 0; y < 960; y += 8)
    for (int x = 0; x < 1280; x += 8) {
      const Eigen::Vector2d pixel(x, y);
      const auto ray = lens.Unproject(pixel);
      num_without += !ray;
      if (ray)
        EXPECT_LT((lens.Project(*ray, nullptr, 1).value() - pixel).norm(),
                  1e-6);
    }
  EXPECT_LE(num_without, 2);
}

TEST(OpenCvModel, FoldMovesWithTheParameters) {
  OpenCvModel lens = FoldingLens(-0.5);
  lens.SetParameters(FoldingLens(0).Parameters());
  EXPECT_TRUE(lens.Project({0.9, 0, 1}));
}

TEST(OpenCvModel, SeesNothingOutsideItsArea) {
  const OpenCvModel lens = ExampleLens().WithArea({100, 100, 300, 200});
  EXPECT_FALSE(lens.Unproject({99.9, 150}));
  EXPECT_FALSE(lens.Unproject({150, 200.1}));
  const Eigen::Vector3d ray = *ExampleLens().Unproject({302, 150});
  EXPECT_FALSE(lens.Project(ray));
  EXPECT_FALSE(lens.Project(ray, nullptr, 1.9));
  EXPECT_TRUE(lens.Project(ray, nullptr, 2.1));
  LinearizedProjection linear;
  EXPECT_FALSE(lens.Linearize(ray, nullptr, 0, &linear));
}

}  // namespace
}  // namespace raygrid
