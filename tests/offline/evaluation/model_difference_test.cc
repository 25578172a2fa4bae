#include "evaluation/model_difference.h"

#include "camera/stereographic.h"
#include "simulation/simulated_camera.h"
#include "support.h"

namespace raygrid {
namespace {

// A camera turned in its housing.
class RotatedCamera : public CameraModel {
 public:
  RotatedCamera(const CameraModel& camera, const Eigen::Quaterniond& rotation)
      : CameraModel(camera.image_size(), camera.area()),
        camera_(camera.Clone()),
        rotation_(rotation) {}

  std::string Name() const override { return "rotated"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<RotatedCamera>(*camera_, rotation_);
  }
  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override {
    const auto ray = camera_->Unproject(pixel);
    if (!ray) return std::nullopt;
    return Eigen::Vector3d(rotation_ * *ray);
  }
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* start,
                                         double margin_px) const override {
    return camera_->Project(rotation_.inverse() * point, start, margin_px);
  }
  bool Linearize(const Eigen::Vector3d& point, const Eigen::Vector2d* start,
                 double margin_px,
                 LinearizedProjection* projection) const override {
    if (!camera_->Linearize(rotation_.inverse() * point, start, margin_px,
                            projection))
      return false;
    projection->J_point *= rotation_.inverse().toRotationMatrix();
    return true;
  }
  Eigen::VectorXd Parameters() const override { return {}; }
  void SetParameters(const Eigen::VectorXd&) override {}

 private:
  std::unique_ptr<CameraModel> camera_;
  Eigen::Quaterniond rotation_;
};

const Eigen::Quaterniond kRotation = RotationFromVector({0.03, -0.07, 0.2});

TEST(CompareModels, FindsNoDifferenceOfACameraFromItself) {
  const CentralGeneric camera = FittedGrid(ExampleSimulatedCamera(), 40);
  const ModelDifference difference = CompareModels(camera, camera, 8);
  EXPECT_EQ(difference.pixels.size(), 80u * 60u);
  EXPECT_LT(difference.max_px, 1e-9);
}

TEST(CompareModels, TakesOutARotation) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const ModelDifference difference =
      CompareModels(camera, RotatedCamera(camera, kRotation), 8);
  EXPECT_GT(difference.pixels.size(), 4000u);
  EXPECT_LT(difference.max_px, 1e-8);
  EXPECT_LT(difference.first_from_second.rotation.angularDistance(
                kRotation.inverse()),
            1e-10);
}

TEST(CompareModels, TakesOutTheRotationOfAFittedGrid) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const CentralGeneric fitted =
      FittedGrid(RotatedCamera(camera, kRotation), 20);
  const ModelDifference difference = CompareModels(camera, fitted, 8);
  EXPECT_LT(difference.max_px, 2e-3);
  EXPECT_LT(difference.first_from_second.rotation.angularDistance(
                kRotation.inverse()),
            1e-6);
}

TEST(CompareModels, ShowsALocalDeformationWhereItIs) {
  const OpenCvModel lens = ExampleLens();
  const Eigen::Vector2d center(200, 300), shift(0.6, -0.3);
  const SimulatedCamera bumped(lens, {{center, shift, 40}});
  const ModelDifference difference = CompareModels(lens, bumped, 4);
  EXPECT_LT(difference.median_px, 0.02);
  EXPECT_NEAR(difference.max_px, shift.norm(), 0.03);
  for (size_t i = 0; i < difference.pixels.size(); ++i)
    EXPECT_TRUE((difference.pixels[i] - center).norm() >= 4 ||
                (difference.error_px[i] + shift).norm() < 0.03);
}

TEST(CompareModels, ShowsAnotherFocalLength) {
  const OpenCvModel lens = ExampleLens();
  OpenCvModel longer = lens;
  Eigen::VectorXd parameters = lens.Parameters();
  parameters.head<2>() *= 1.01;
  longer.SetParameters(parameters);
  const ModelDifference difference = CompareModels(lens, longer, 8);
  EXPECT_GT(difference.max_px, 3);  // 1 % of 400 px
  EXPECT_LT(difference.max_px, 5);
  EXPECT_LE(difference.median_px, difference.p99_px);
  EXPECT_LE(difference.p99_px, difference.max_px);
}

TEST(CompareModels, ComparesOnlyWhereBothAreCalibrated) {
  const OpenCvModel lens = ExampleLens();
  const OpenCvModel inner = lens.WithArea({100, 100, 300, 200});
  for (const auto& difference :
       {CompareModels(lens, inner, 5), CompareModels(inner, lens, 5)}) {
    EXPECT_FALSE(difference.pixels.empty());
    for (const Eigen::Vector2d& pixel : difference.pixels)
      EXPECT_TRUE(inner.area().Contains(pixel));
  }
}

TEST(CompareModels, TakesOutARotationAndATranslationOfLines) {
  const NonCentralGeneric camera = ExampleLines();
  const Eigen::Vector3d origin(0.004, -0.003, 0.012);
  const ModelDifference difference =
      CompareModels(camera, camera.WithOrigin(origin), 8, 0.4);
  EXPECT_EQ(difference.pixels.size(), 2u * 80u * 60u);
  EXPECT_LT(difference.max_px, 1e-6);
  EXPECT_LT((difference.first_from_second.translation - origin).norm(), 1e-9);
}

TEST(CompareModels, LinesThatDriftAlongThemselvesAreTheSame) {
  const NonCentralGeneric camera = ExampleLines();
  NonCentralGeneric drifted = camera;
  Eigen::VectorXd parameters = camera.Parameters();
  for (Eigen::Index k = 0; k < parameters.size(); k += 5)
    parameters.segment<3>(k + 2) += 0.01 * FromChart(parameters.segment<2>(k));
  drifted.SetParameters(parameters);
  EXPECT_LT(CompareModels(camera, drifted, 8, 0.4).max_px, 0.01);
}

TEST(CompareModels, ShowsWhatIsNotCentral) {
  const NonCentralGeneric lines = ExampleLines();
  const ModelDifference near = CompareModels(lines, MakeCentral(lines), 8, 0.4);
  EXPECT_GT(near.max_px, 0.2);
  EXPECT_LT(CompareModels(lines, MakeCentral(lines), 8, 400).max_px, 0.01);
}

}  // namespace
}  // namespace raygrid
