#include "camera/lens_models.h"

#include <opencv2/calib3d.hpp>

#include "camera/model_fitting.h"
#include "support.h"

namespace raygrid {
namespace {

// Every parameter of every formula at work.
struct Example {
  const char* model;
  std::vector<double> parameters;
};

const std::vector<Example>& Examples() {
  static const std::vector<Example> examples = {
      {"opencv-14",
       {510, 515, 322, 236, -0.15, 0.06, 1e-3, -8e-4, 0.01, 0.1, 0.02, 5e-3,
        2e-3, -1e-3, 3e-3, 1.5e-3, 0.02, -0.03}},
      {"omni-radtan", {620, 615, 322, 236, 0.9, -0.1, 0.02, 1e-3, -8e-4}},
      {"double-sphere", {180, 181, 322, 236, -0.2, 0.6}},
      {"eucm", {230, 231, 322, 236, 0.6, 1.1}}};
  return examples;
}

std::unique_ptr<ParametricModel> LensOf(const Example& example) {
  const ImageSize size = {640, 480};
  return FindLensModel(example.model)
      ->make(size, WholeImage(size),
             Eigen::Map<const Eigen::VectorXd>(example.parameters.data(),
                                               example.parameters.size()));
}

TEST(LensModels, ProjectionInvertsUnprojection) {
  for (const Example& example : Examples()) {
    SCOPED_TRACE(example.model);
    ExpectRoundTrip(*LensOf(example), 1e-6);
  }
}

TEST(LensModels, DerivativesAreThoseOfProjection) {
  for (const Example& example : Examples()) {
    SCOPED_TRACE(example.model);
    ExpectDerivativeByPoint(*LensOf(example), 1e-6);
    ExpectDerivativeByParameter(*LensOf(example), 1e-5, 1e-6);
  }
}

TEST(LensModels, LookStraightAheadInTheirCentre) {
  for (const Example& example : Examples()) {
    Example plain = example;
    if (plain.model == std::string("opencv-14"))
      std::fill(plain.parameters.begin() + 4, plain.parameters.end(), 0);
    const auto ray = LensOf(plain)->Unproject({322, 236});
    ASSERT_TRUE(ray) << plain.model;
    EXPECT_LT((*ray - Eigen::Vector3d::UnitZ()).norm(), 1e-9) << plain.model;
  }
}

TEST(LensModels, FitACameraOfTheirKind) {
  for (const Example& example : Examples()) {
    const auto lens = LensOf(example);
    const FittedModel fit =
        FitParametricModel(example.model, *lens, lens->area(), {});
    EXPECT_LT(fit.rms_px, 1e-3) << example.model;
  }
}

TEST(LensModels, OpenCv14AgreesWithOpenCv) {
  const Example& example = Examples().front();
  const std::vector<double>& p = example.parameters;
  const auto lens = LensOf(example);
  const cv::Matx33d matrix(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
  const std::vector<double> distortion(p.begin() + 4, p.end());
  TestRandom random(1);
  int num_seen = 0;
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d point(random.Uniform(-1, 1), random.Uniform(-1, 1),
                                random.Uniform(0.5, 3));
    const auto pixel = lens->Project(point);
    if (!pixel) continue;
    ++num_seen;
    std::vector<cv::Point2d> seen;
    cv::projectPoints(
        std::vector<cv::Point3d>{{point.x(), point.y(), point.z()}},
        cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), matrix, distortion, seen);
    EXPECT_LT((*pixel - Eigen::Vector2d(seen[0].x, seen[0].y)).norm(), 1e-9);
  }
  EXPECT_GT(num_seen, 300);
}

// The unified model with alpha = xi / (1 + xi) and beta = 1, and the double
// sphere without its first sphere, are one lens in three models.
TEST(LensModels, AgreeWhereTheyAreOneLens) {
  const double xi = 0.8, alpha = xi / (1 + xi), f = 250;
  const auto omni = LensOf(
      {"omni-radtan", {f * (1 + xi), f * (1 + xi), 322, 236, xi, 0, 0, 0, 0}});
  const auto eucm = LensOf({"eucm", {f, f, 322, 236, alpha, 1}});
  const auto sphere = LensOf({"double-sphere", {f, f, 322, 236, 0, alpha}});
  TestRandom random(2);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d ray =
        omni->Unproject(random.PixelIn(omni->area())).value();
    const Eigen::Vector2d pixel = omni->Project(ray, nullptr, 1).value();
    for (const ParametricModel* other : {eucm.get(), sphere.get()})
      EXPECT_LT((other->Project(ray, nullptr, 1).value() - pixel).norm(), 1e-8);
  }
}

// alpha = 1 and beta = 1 shows a direction at the sine of its angle: nothing
// beyond 90 degrees.
TEST(LensModels, EndWhereTheRadiusStopsToGrow) {
  const auto lens = LensOf({"eucm", {200, 200, 322, 236, 1, 1}});
  EXPECT_TRUE(lens->Project({1, 0, 0.1}, nullptr, 0));
  EXPECT_FALSE(lens->Project({1, 0, -0.1}, nullptr, 0));
  EXPECT_FALSE(lens->Unproject({322 + 201, 236}));
  EXPECT_FALSE(lens->Project({0, 0, 0}));
}

TEST(LensModels, KnowNoOthers) {
  EXPECT_EQ(FindLensModel("central-radial"), nullptr);
  EXPECT_EQ(FindLensModel("equidistant"), nullptr);
  EXPECT_TRUE(IsParametricModel("eucm"));
}

}  // namespace
}  // namespace raygrid
