// Cameras on a rig, with known truth.

#include <algorithm>
#include <cmath>
#include <set>

#include "calibration/calibration.h"
#include "calibration/rig_evaluation.h"
#include "dataset/camera_file.h"
#include "dataset/rig_file.h"
#include "evaluation/model_difference.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_rig.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

constexpr double kRigNoisePx = 0.05;

SimulationOptions CollectFrameSets(int count) {
  SimulationOptions options;
  options.num_images = count;
  options.features_per_image = 140;
  options.noise_px = kRigNoisePx;
  return options;
}

std::shared_ptr<const CameraModel> SmallLens() {
  const ImageSize size = {400, 300};
  return std::make_shared<OpenCvModel>(
      size, WholeImage(size),
      OpenCvModel::ParameterArray{350, 352, 203, 148, -0.1, 0.03, 0.005, 0.05,
                                  0.01, 0.002, 5e-4, -3e-4});
}

// Turned against each other, with images of two sizes.
SimulatedRig StereoWith(std::shared_ptr<const CameraModel> left) {
  return {{std::move(left), SmallLens()},
          {{}, {RotationFromVector({0.02, -0.15, 0.05}), {-0.12, 0.01, 0.03}}}};
}
SimulatedRig Stereo() {
  return StereoWith(std::make_shared<OpenCvModel>(ExampleLens()));
}

// The outer two share nothing.
SimulatedRig Fan() {
  const auto lens = std::make_shared<OpenCvModel>(ExampleLens());
  return {{lens, lens, lens},
          {{},
           {RotationFromVector({0, -0.85, 0}), {-0.1, 0, 0}},
           {RotationFromVector({0, -1.7, 0}), {-0.2, 0, 0.1}}}};
}

std::vector<CalibrationInput> Inputs(const SimulatedRigObservations& seen) {
  const char* names[] = {"left", "right", "rear"};
  std::vector<CalibrationInput> inputs;
  for (size_t c = 0; c < seen.datasets.size(); ++c)
    inputs.push_back({names[c], seen.datasets[c]});
  return inputs;
}

CalibrationOptions Quick() {
  CalibrationOptions options;
  options.model = "opencv";
  options.num_threads = 2;
  return options;
}

// Nothing is held out of these.
CalibrationOptions QuickWithout(const std::string& frame) {
  CalibrationOptions options = Quick();
  options.hold_out = {frame};
  return options;
}

std::set<std::string> NamesOf(const Dataset& dataset) {
  std::set<std::string> names;
  for (const ImageFeatures& image : dataset.images) names.insert(image.image);
  return names;
}

int NumShared(const Dataset& a, const Dataset& b) {
  int count = 0;
  for (const std::string& name : NamesOf(a)) count += NamesOf(b).count(name);
  return count;
}

const Baseline& BaselineOf(const RigResult& result, size_t a, size_t b) {
  return *std::find_if(
      result.baselines.begin(), result.baselines.end(),
      [&](const Baseline& x) { return x.first == a && x.second == b; });
}

TEST(SimulatedRig, SharesInstantsAndMissesSome) {
  const SimulatedRigObservations seen =
      SimulateRig(Fan(), TestBoard(), CollectFrameSets(30));
  EXPECT_GT(NumShared(seen.datasets[0], seen.datasets[1]), 5);
  EXPECT_GT(NumShared(seen.datasets[1], seen.datasets[2]), 5);
  EXPECT_EQ(NumShared(seen.datasets[0], seen.datasets[2]), 0);
  for (const Dataset& dataset : seen.datasets)
    EXPECT_LT(dataset.images.size(), 30u);
}

// Between the true frames, which found cameras may be turned from.
Pose RelativePose(const RigResult& result, const SimulatedRig& truth, size_t a,
                  size_t b) {
  const auto turned = [&](size_t c) {
    return CompareModels(*truth.cameras[c], *result.cameras[c].camera.camera,
                         25)
        .first_from_second;
  };
  return turned(b) *
         (result.camera_from_rig[b] * result.camera_from_rig[a].Inverse()) *
         turned(a).Inverse();
}

// Within four of the result's own standard deviations, which are small.
void ExpectBaseline(const RigResult& result, const SimulatedRig& truth,
                    size_t a, size_t b) {
  const Pose found = RelativePose(result, truth, a, b);
  const Pose expected =
      truth.camera_from_rig[b] * truth.camera_from_rig[a].Inverse();
  const Baseline& baseline = BaselineOf(result, a, b);
  EXPECT_LT(*baseline.distance_stddev_m, 1e-3 * expected.translation.norm());
  EXPECT_LT(std::abs(found.translation.norm() - expected.translation.norm()),
            4 * *baseline.distance_stddev_m);
  EXPECT_LT(*baseline.rotation_stddev_rad, 2e-3);
  EXPECT_LT(found.rotation.angularDistance(expected.rotation),
            4 * *baseline.rotation_stddev_rad);
  EXPECT_LT((found.translation - expected.translation).norm(),
            4 * (*baseline.distance_stddev_m +
                 expected.translation.norm() * *baseline.rotation_stddev_rad));
}

TEST(CalibrateRig, FindsTheRelativePoseOfTwoCameras) {
  const SimulatedRig rig =
      StereoWith(std::make_shared<SimulatedCamera>(ExampleSimulatedCamera()));
  const SimulatedRigObservations seen =
      SimulateRig(rig, TestBoard(), CollectFrameSets(20));
  const RigResult result = Calibrate(Inputs(seen), TestBoard(), [] {
    CalibrationOptions options = Quick();
    options.model = "central-generic";
    options.knot_spacing_px = 100;
    return options;
  }());
  ExpectBaseline(result, rig, 0, 1);
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(result.cameras[1].camera.camera->image_size().width, 400);
  EXPECT_NEAR(ComputeTrainingMetrics(result).rms_px, kRigNoisePx * std::sqrt(2),
              0.01);
  EXPECT_TRUE(result.cross_validated);
  EXPECT_NEAR(ComputeHeldOutMetrics(result)->rms_px, kRigNoisePx * std::sqrt(2),
              0.015);
}

TEST(CalibrateRig, ConnectsCamerasThroughOthers) {
  const SimulatedRig rig = Fan();
  const SimulatedRigObservations seen =
      SimulateRig(rig, TestBoard(), CollectFrameSets(36));
  const RigResult result =
      Calibrate(Inputs(seen), TestBoard(), QuickWithout("sim0000.png"));
  EXPECT_EQ(BaselineOf(result, 0, 2).num_shared_views, 0);
  EXPECT_GT(BaselineOf(result, 0, 1).num_shared_views, 5);
  ExpectBaseline(result, rig, 0, 2);
}

TEST(CalibrateRig, NamesGroupsThatAreNotConnected) {
  const SimulatedRigObservations seen =
      SimulateRig(Fan(), TestBoard(), CollectFrameSets(36));
  std::vector<CalibrationInput> inputs = Inputs(seen);
  for (ImageFeatures& image : inputs[2].dataset.images) image.image += ".bmp";
  ExpectError(ExitCode::kInitializationFailed, {"{left, right}, {rear}"},
              [&] { Calibrate(inputs, TestBoard(), Quick()); });
}

TEST(CalibrateRig, OneBoardAtOneInstantConnects) {
  // The cameras' images share names, but not boards.
  SimulatedRigObservations seen =
      SimulateRig(Stereo(), TwoTestBoards(), CollectFrameSets(12));
  for (int c = 0; c < 2; ++c)
    for (ImageFeatures& image : seen.datasets[c].images) {
      std::vector<Feature> kept;
      for (const Feature& feature : image.features)
        if ((feature.board == 7) == (c == 1)) kept.push_back(feature);
      image.features = kept;
    }
  ExpectError(ExitCode::kInitializationFailed, {"{left}, {right}"},
              [&] { Calibrate(Inputs(seen), TwoTestBoards(), Quick()); });
}

TEST(CalibrateRig, EachBoardOfSeveralHasItsOwnPoses) {
  const SimulatedRig rig = Stereo();
  const SimulatedRigObservations seen =
      SimulateRig(rig, TwoTestBoards(), CollectFrameSets(14));
  const RigResult result =
      Calibrate(Inputs(seen), TwoTestBoards(), QuickWithout("sim0003.png"));
  ExpectBaseline(result, rig, 0, 1);
  EXPECT_GT(BaselineOf(result, 0, 1).num_shared_views, 13);
}

TEST(CalibrateRig, ScaleIsThatOfTheBoardsThoughTheyAreBent) {
  const SimulatedRig rig = Stereo();
  SimulationOptions options = CollectFrameSets(24);
  options.board_sagitta_m = 0.003;
  const SimulatedRigObservations seen = SimulateRig(rig, TestBoard(), options);
  const RigResult result =
      Calibrate(Inputs(seen), TestBoard(), QuickWithout("sim0003.png"));
  ExpectBaseline(result, rig, 0, 1);
}

// White noise of the residuals' size would make the baseline ten times better
// known than it is.
TEST(CalibrateRig, DeviationsCountNoiseThatNeighboursShare) {
  constexpr int kSeeds = 6;
  const std::shared_ptr<const CameraModel> lens =
      MakeSimulatedCamera("pinhole", {640, 480});
  const SimulatedRig rig = {
      {lens, lens}, {{}, {Eigen::Quaterniond::Identity(), {-0.1, 0, 0}}}};
  double squares = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    SimulationOptions options = CollectFrameSets(20);
    options.shared_noise_px = 0.1;
    options.seed = static_cast<uint64_t>(seed);
    const SimulatedRigObservations seen =
        SimulateRig(rig, TestBoard(), options);
    CalibrationOptions quick = QuickWithout("sim0003.png");
    quick.rigid_board = true;
    const RigResult result = Calibrate(Inputs(seen), TestBoard(), quick);
    const Baseline& baseline = BaselineOf(result, 0, 1);
    squares +=
        std::pow((baseline.distance_m - 0.1) / *baseline.distance_stddev_m, 2);
  }
  const double rms = std::sqrt(squares / kSeeds);
  EXPECT_GT(rms, 0.5);
  EXPECT_LT(rms, 2);
}

TEST(CalibrateRig, RejectsViewsOfAnotherInstantByName) {
  const SimulatedRig rig = Stereo();
  const SimulatedRigObservations seen =
      SimulateRig(rig, TestBoard(), CollectFrameSets(24));
  std::vector<CalibrationInput> inputs = Inputs(seen);
  // Two images of the right camera were swapped.
  std::vector<ImageFeatures*> shared;
  const std::set<std::string> left = NamesOf(inputs[0].dataset);
  for (ImageFeatures& image : inputs[1].dataset.images)
    if (left.count(image.image)) shared.push_back(&image);
  ASSERT_GT(shared.size(), 8u);
  std::swap(shared[2]->features, shared[5]->features);
  const RigResult result =
      Calibrate(inputs, TestBoard(), QuickWithout(shared[0]->image));
  std::set<std::string> rejected;
  for (const CalibrationResult& camera : result.cameras)
    for (const RejectedImage& image : camera.rejected_images)
      rejected.insert(image.image);
  EXPECT_EQ(rejected,
            (std::set<std::string>{shared[2]->image, shared[5]->image}));
  ExpectBaseline(result, rig, 0, 1);
}

TEST(CalibrateRig, RefusesImagesThatAreOfOtherInstantsAltogether) {
  const SimulatedRigObservations seen =
      SimulateRig(Stereo(), TestBoard(), CollectFrameSets(20));
  std::vector<CalibrationInput> inputs = Inputs(seen);
  auto& images = inputs[1].dataset.images;
  for (size_t i = 0; i < images.size() / 2; ++i)
    std::swap(images[i].features, images[images.size() - 1 - i].features);
  ExpectError(ExitCode::kInitializationFailed,
              {"left", "right", "synchronized"},
              [&] { Calibrate(inputs, TestBoard(), Quick()); });
}

TEST(CalibrateRig, NamesTheCameraWithTooFewImages) {
  const SimulatedRigObservations seen =
      SimulateRig(Stereo(), TestBoard(), CollectFrameSets(20));
  std::vector<CalibrationInput> inputs = Inputs(seen);
  auto& images = inputs[1].dataset.images;
  const std::set<std::string> left = NamesOf(inputs[0].dataset);
  images.erase(std::remove_if(images.begin(), images.end(),
                              [&](const ImageFeatures& image) {
                                return left.count(image.image) == 0;
                              }),
               images.end());
  images.resize(2);
  ExpectError(ExitCode::kInsufficientData, {"camera right", "2 images"},
              [&] { Calibrate(inputs, TestBoard(), Quick()); });
}

TEST(CalibrateRig, RefusesTwoCamerasOfOneName) {
  const SimulatedRigObservations seen =
      SimulateRig(Stereo(), TestBoard(), CollectFrameSets(6));
  std::vector<CalibrationInput> inputs = Inputs(seen);
  inputs[1].name = "left";
  ExpectError(ExitCode::kUsage, {"name"},
              [&] { Calibrate(inputs, TestBoard(), Quick()); });
}

TEST(CalibrateRig, RefusesToBeOfNoCamera) {
  ExpectError(ExitCode::kUsage, {"no camera"}, [] {
    Calibrate(std::vector<CalibrationInput>(), TestBoard(), Quick());
  });
}

TEST(CalibrateRig, OfOneCameraIsASingleCamera) {
  const SimulatedRigObservations seen =
      SimulateRig(Stereo(), TestBoard(), CollectFrameSets(9));
  std::vector<CalibrationInput> inputs = Inputs(seen);
  inputs.pop_back();
  const RigResult rig = Calibrate(inputs, TestBoard(), Quick());
  ASSERT_EQ(rig.cameras.size(), 1u);
  EXPECT_TRUE(rig.held_out.empty());
  CameraFile named = rig.cameras[0].camera;
  EXPECT_EQ(named.name, "left");
  named.name = "";
  EXPECT_EQ(FormatCameraFile(named),
            FormatCameraFile(
                Calibrate(seen.datasets[0], TestBoard(), Quick()).camera));
}

TEST(CalibrateRig, GivesTheSameBytesWithAnyNumberOfThreads) {
  const SimulatedRigObservations seen =
      SimulateRig(Stereo(), TestBoard(), CollectFrameSets(10));
  std::string text[2];
  for (int k = 0; k < 2; ++k) {
    CalibrationOptions options = Quick();
    options.num_threads = k + 1;
    const RigResult result = Calibrate(Inputs(seen), TestBoard(), options);
    for (const CalibrationResult& camera : result.cameras)
      text[k] += FormatCameraFile(camera.camera) + FormatPoses(camera.poses) +
                 FormatFeatures(camera.features);
    text[k] += FormatPattern(result.pattern) +
               FormatRigFile({{"left", "a", result.camera_from_rig[0]},
                              {"right", "b", result.camera_from_rig[1]}});
  }
  EXPECT_EQ(text[0], text[1]);
}

// All images of a camera again, or one under another name, would make a rig
// without a baseline.
TEST(CalibrateRig, RefusesOneCameraAsTwo) {
  const auto seen = SimulateRig(Stereo(), TestBoard(), CollectFrameSets(8));
  std::vector<CalibrationInput> inputs = Inputs(seen);
  inputs[1].dataset = inputs[0].dataset;
  ExpectError(ExitCode::kInvalidInput, {"'left'", "'right'", "share an image"},
              [&] { Calibrate(inputs, TestBoard(), {}); });
  inputs = Inputs(seen);
  const std::string copied = inputs[0].dataset.images[2].image;
  inputs[1].dataset.images[5].features = inputs[0].dataset.images[2].features;
  ExpectError(ExitCode::kInvalidInput,
              {"'left'", "'right'", copied, inputs[1].dataset.images[5].image},
              [&] { Calibrate(inputs, TestBoard(), {}); });
}

TEST(EvaluateRig, FindsTheNoiseOfATrueRigAndTheErrorOfAWrongOne) {
  const SimulatedRig truth = Stereo();
  const SimulatedRigObservations seen =
      SimulateRig(truth, TestBoard(), CollectFrameSets(10));
  RigModel rig;
  for (const auto& camera : truth.cameras) rig.cameras.push_back(camera.get());
  rig.camera_from_rig = truth.camera_from_rig;
  const auto right = EvaluateRig(rig, seen.datasets, TestBoard(), 2);
  rig.camera_from_rig[1].translation.x() += 0.003;
  const auto wrong = EvaluateRig(rig, seen.datasets, TestBoard(), 2);
  for (int c = 0; c < 2; ++c) {
    EXPECT_TRUE(right[c].rejected_images.empty());
    EXPECT_NEAR(ComputeErrorMetrics(right[c].residuals).rms_px,
                kRigNoisePx * std::sqrt(2), 0.007);
    EXPECT_GT(ComputeErrorMetrics(wrong[c].residuals).rms_px, 0.2);
  }
}

}  // namespace
}  // namespace raygrid
