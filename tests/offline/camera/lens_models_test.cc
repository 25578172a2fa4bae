#include <opencv2/calib3d.hpp>

#include "camera/model_fitting.h"
#include "camera/model_registry.h"
#include "support.h"

namespace raygrid {
namespace {

std::unique_ptr<ParametricModel> LensOf(const ModelInfo& model,
                                        const Eigen::VectorXd& parameters) {
  const ImageSize size = {640, 480};
  return model.make(size, WholeImage(size), parameters);
}

std::unique_ptr<ParametricModel> LensOf(const char* model,
                                        const std::vector<double>& parameters) {
  return LensOf(
      *FindModelInfo(model),
      Eigen::Map<const Eigen::VectorXd>(parameters.data(), parameters.size()));
}

// Parameters of which every one is at work.
Eigen::VectorXd ExampleOf(const ModelInfo& model) {
  Eigen::VectorXd parameters = model.starts(230, 322, 236).front();
  for (Eigen::Index k = 0; k < parameters.size(); ++k)
    parameters[k] +=
        (k % 2 == 0 ? 0.03 : -0.02) / std::pow(1.0 + static_cast<double>(k), 2);
  return parameters;
}

// Calls test with each model and an example of it.
template <typename Test>
void ForEachModel(const Test& test) {
  for (const ModelInfo& model : GetModelRegistry()) {
    SCOPED_TRACE(model.name);
    if (model.make) test(model, *LensOf(model, ExampleOf(model)));
  }
}

TEST(GetModelRegistry, ProjectionInvertsUnprojection) {
  ForEachModel([](const ModelInfo&, const ParametricModel& lens) {
    ExpectRoundTrip(lens, 1e-6);
  });
}

TEST(GetModelRegistry, DerivativesAreThoseOfProjection) {
  ForEachModel([](const ModelInfo&, const ParametricModel& lens) {
    ExpectDerivativeByPoint(lens, 1e-6);
    ExpectDerivativeByParameter(lens, 1e-5, 1e-6);
  });
}

TEST(GetModelRegistry, LookStraightAheadInTheirCentreIfNotTilted) {
  ForEachModel([](const ModelInfo& model, const ParametricModel& lens) {
    Eigen::VectorXd plain = lens.Parameters();
    const std::vector<int> orders = lens.DistortionOrders();
    ASSERT_EQ(orders.size(), model.parameters.size());
    for (Eigen::Index k = 0; k < plain.size(); ++k)
      if (orders[k] < 0) plain[k] = 0;
    const auto ray = LensOf(model, plain)->Unproject({plain[2], plain[3]});
    ASSERT_TRUE(ray);
    EXPECT_LT((*ray - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
  });
}

TEST(GetModelRegistry, SeeNothingOutsideTheirArea) {
  ForEachModel([](const ModelInfo&, const ParametricModel& whole) {
    const auto lens = whole.CloneWithArea({100, 100, 300, 200});
    EXPECT_FALSE(lens->Unproject({99.9, 150}));
    EXPECT_FALSE(lens->Unproject({150, 200.1}));
    const Eigen::Vector3d ray = whole.Unproject({302, 150}).value();
    EXPECT_FALSE(lens->Project(ray, nullptr, 1.9));
    EXPECT_TRUE(lens->Project(ray, nullptr, 2.1));
    LinearizedProjection linear;
    EXPECT_FALSE(lens->Linearize(ray, nullptr, 0, &linear));
  });
}

TEST(GetModelRegistry, FitACameraOfTheirKind) {
  ForEachModel([](const ModelInfo& model, const ParametricModel& lens) {
    const FittedModel fit =
        FitParametricModel(model.name, lens, lens.area(), {});
    EXPECT_LT(fit.rms_px, 1e-3);
  });
}

void ExpectAgreementWithOpenCv(const ModelInfo& model) {
  const Eigen::VectorXd p = ExampleOf(model);
  const auto lens = LensOf(model, p);
  const cv::Matx33d matrix(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
  std::vector<double> distortion;
  for (const char* name : {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1",
                           "s2", "s3", "s4", "tx", "ty"})
    for (size_t k = 0; k < model.parameters.size(); ++k)
      if (model.parameters[k] == name) distortion.push_back(p[k]);
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

TEST(GetModelRegistry, AgreeWithOpenCv) {
  for (const char* model : {"opencv", "opencv-14"})
    ExpectAgreementWithOpenCv(*FindModelInfo(model));
}

// The unified model with alpha = xi / (1 + xi) and beta = 1, and the double
// sphere without its first sphere, are one lens in three models.
TEST(GetModelRegistry, AgreeWhereTheyAreOneLens) {
  const double xi = 0.8, alpha = xi / (1 + xi), f = 250;
  const auto omni = LensOf(
      "omni-radtan", {f * (1 + xi), f * (1 + xi), 322, 236, xi, 0, 0, 0, 0});
  const auto eucm = LensOf("eucm", {f, f, 322, 236, alpha, 1});
  const auto sphere = LensOf("double-sphere", {f, f, 322, 236, 0, alpha});
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
TEST(GetModelRegistry, EndWhereTheRadiusStopsToGrow) {
  const auto lens = LensOf("eucm", {200, 200, 322, 236, 1, 1});
  EXPECT_TRUE(lens->Project({1, 0, 0.1}, nullptr, 0));
  EXPECT_FALSE(lens->Project({1, 0, -0.1}, nullptr, 0));
  EXPECT_FALSE(lens->Unproject({322 + 201, 236}));
  EXPECT_FALSE(lens->Project({0, 0, 0}));
}

TEST(GetModelRegistry, KnowNoOthers) {
  EXPECT_FALSE(FindModelInfo("central-radial")->make);
  EXPECT_EQ(FindModelInfo("equidistant"), nullptr);
  EXPECT_TRUE(IsParametricModel("eucm"));
}

}  // namespace
}  // namespace raygrid
