#include "calibration/target_localization.h"

#include <cmath>
#include <string>

#include "evaluation/residual_statistics.h"
#include "simulation/simulated_observations.h"
#include "simulation/simulated_rig.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

SimulationOptions LocalizedViews(int count, double noise_px) {
  SimulationOptions options;
  options.num_images = count;
  options.features_per_image = 100;
  options.noise_px = noise_px;
  return options;
}

SimulatedRig RigOfTwo() {
  return MakeCameraRow(std::make_shared<OpenCvModel>(ExampleLens()), 2, 0.2);
}

RigModel ModelOf(const SimulatedRig& rig) {
  RigModel model;
  for (const auto& camera : rig.cameras) model.cameras.push_back(camera.get());
  model.camera_from_rig = rig.camera_from_rig;
  return model;
}

const Pose* FindPose(const std::vector<BoardPose>& poses,
                     const std::string& image) {
  for (const BoardPose& pose : poses)
    if (pose.image == image) return &pose.camera_from_board;
  return nullptr;
}

// The update of UpdatedPose() that turns an estimate into the truth.
Eigen::Matrix<double, 6, 1> ErrorOf(const Pose& estimate, const Pose& truth) {
  const Eigen::AngleAxisd turn(truth.rotation * estimate.rotation.conjugate());
  Eigen::Matrix<double, 6, 1> error;
  error << turn.angle() * turn.axis(), truth.translation - estimate.translation;
  return error;
}

// The mean squared Mahalanobis distance of the poses from the truth, per
// degree of freedom: 1 if the covariances are right.
double ComputeErrorRatio(const std::vector<TargetPose>& poses,
                         const std::vector<BoardPose>& truth, int* count) {
  double sum = 0;
  *count = 0;
  for (const TargetPose& target : poses) {
    const Pose* pose = FindPose(truth, target.pose.image);
    if (!pose) continue;
    const auto error = ErrorOf(target.pose.camera_from_board, *pose);
    sum += error.dot(target.covariance.ldlt().solve(error)) / 6;
    ++*count;
  }
  return sum / *count;
}

TEST(LocalizeTargets, CovariancesAreThoseOfTheErrors) {
  constexpr double kNoisePx = 0.1;
  const OpenCvModel central = ExampleLens();
  const NonCentralGeneric lines = ExampleLines();
  for (const CameraModel* camera : {static_cast<const CameraModel*>(&central),
                                    static_cast<const CameraModel*>(&lines)}) {
    const SimulatedObservations seen = SimulateObservations(
        *camera, TestBoard(), LocalizedViews(100, kNoisePx));
    const TargetLocalization found =
        LocalizeTargets({{camera}, {Pose()}}, {seen.dataset}, TestBoard(), 2);
    int count = 0;
    const double ratio = ComputeErrorRatio(found.poses, seen.poses, &count);
    EXPECT_EQ(count, 100);
    EXPECT_NEAR(ratio, 1, 0.2) << camera->Name();
    EXPECT_NEAR(found.noise_px, kNoisePx, 0.005);
    EXPECT_EQ(found.cameras[0].residuals.size() +
                  static_cast<size_t>(found.cameras[0].outside_area),
              seen.dataset.num_features());
  }
}

TEST(LocalizeTargets, CamerasOfARigShareAPose) {
  const SimulatedRig rig = RigOfTwo();
  const SimulatedRigObservations seen =
      SimulateRig(rig, TestBoard(), LocalizedViews(80, 0.1));
  const TargetLocalization found =
      LocalizeTargets(ModelOf(rig), seen.datasets, TestBoard(), 2);
  int count = 0;
  EXPECT_NEAR(ComputeErrorRatio(found.poses, seen.poses[0], &count), 1, 0.25);
  EXPECT_GT(count, 40);
  double stddev_of_both = 0, stddev_of_one = 0;
  const TargetLocalization alone = LocalizeTargets(
      {{rig.cameras[0].get()}, {Pose()}}, {seen.datasets[0]}, TestBoard(), 2);
  for (const TargetPose& one : alone.poses)
    for (const TargetPose& both : found.poses)
      if (one.pose.image == both.pose.image) {
        stddev_of_one += one.TranslationStdDev();
        stddev_of_both += both.TranslationStdDev();
      }
  EXPECT_LT(stddev_of_both, 0.8 * stddev_of_one);
}

TEST(LocalizeTargets, OutliersDoNotMoveThePose) {
  const OpenCvModel camera = ExampleLens();
  SimulatedObservations seen =
      SimulateObservations(camera, TestBoard(), LocalizedViews(10, 0.1));
  for (ImageFeatures& image : seen.dataset.images)
    image.features[7].pixel = camera.area().center();
  const TargetLocalization found =
      LocalizeTargets({{&camera}, {Pose()}}, {seen.dataset}, TestBoard(), 2);
  ASSERT_EQ(found.poses.size(), 10u);
  for (const TargetPose& target : found.poses) {
    const auto error = ErrorOf(target.pose.camera_from_board,
                               *FindPose(seen.poses, target.pose.image));
    EXPECT_LT(error.dot(target.covariance.ldlt().solve(error)), 40);
  }
}

TEST(LocalizeTargets, RejectsImagesWithFewFeatures) {
  const OpenCvModel camera = ExampleLens();
  SimulatedObservations seen =
      SimulateObservations(camera, TestBoard(), LocalizedViews(3, 0.1));
  seen.dataset.images[1].features.resize(7);
  const TargetLocalization found =
      LocalizeTargets({{&camera}, {Pose()}}, {seen.dataset}, TestBoard(), 1);
  EXPECT_EQ(found.poses.size(), 2u);
  ASSERT_EQ(found.cameras[0].rejected_images.size(), 1u);
  EXPECT_EQ(found.cameras[0].rejected_images[0].image,
            seen.dataset.images[1].image);
}

// ---- Target geometry -------------------------------------------------------

double RmsOf(const std::vector<Eigen::Vector3d>& points,
             const std::vector<Eigen::Vector3d>& others) {
  double sum = 0;
  for (size_t i = 0; i < points.size(); ++i)
    sum += (points[i] - others[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(points.size()));
}

TEST(EstimateTargetGeometry, FindsTheDeformationOfATarget) {
  const OpenCvModel camera = ExampleLens();
  SimulationOptions options = LocalizedViews(12, 0.05);
  options.board_sagitta_m = 0.004;
  const SimulatedObservations seen =
      SimulateObservations(camera, TestBoard(), options);
  const RigModel alone = {{&camera}, {Pose()}};
  const Pattern found =
      EstimateTargetGeometry(alone, {seen.dataset}, TestBoard(), 2);
  const auto rms_px = [&](const Pattern& pattern) {
    return ComputeErrorMetrics(
               LocalizeTargets(alone, {seen.dataset}, pattern, 2)
                   .cameras[0]
                   .residuals)
        .rms_px;
  };
  EXPECT_GT(rms_px(TestBoard()), 5 * 0.05);
  EXPECT_LT(rms_px(found), 1.1 * std::sqrt(2) * 0.05);
}

TEST(EstimateTargetGeometry, RigsDetermineTheSizeOfTheTarget) {
  const SimulatedRig rig = RigOfTwo();
  const SimulatedRigObservations seen =
      SimulateRig(rig, TestBoard(), LocalizedViews(12, 0.05));
  const Pattern too_large = ChessboardPattern(14, 10, 0.0303);
  const Pattern found =
      EstimateTargetGeometry(ModelOf(rig), seen.datasets, too_large, 2);
  EXPECT_GT(RmsOf(too_large.boards[0].points, TestBoard().boards[0].points),
            1e-3);
  // Alignment to the points that were given keeps the middle in place.
  const auto length = [](const Pattern& pattern) {
    const auto& points = pattern.boards[0].points;
    return (points.back() - points.front()).norm();
  };
  EXPECT_NEAR(length(found), length(TestBoard()), 2e-4);
}

TEST(EstimateTargetGeometry, RefusesTwoPoses) {
  const OpenCvModel camera = ExampleLens();
  const SimulatedObservations seen =
      SimulateObservations(camera, TestBoard(), LocalizedViews(2, 0.05));
  ExpectError(ExitCode::kInsufficientData, {"2 of at least 3 poses"}, [&] {
    EstimateTargetGeometry({{&camera}, {Pose()}}, {seen.dataset}, TestBoard(),
                           1);
  });
}

}  // namespace
}  // namespace raygrid
