// How a calibration behaves; how accurate it is, accuracy_test.cc says.

#include "calibration/calibration.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>

#include "calibration/camera_evaluation.h"
#include "camera/thin_prism_fisheye.h"
#include "evaluation/model_difference.h"
#include "evaluation/noncentrality.h"
#include "simulation/noncentral_simulated_camera.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_observations.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

Dataset Simulate(int num_images, int features_per_image = 80) {
  SimulationOptions options;
  options.num_images = num_images;
  options.features_per_image = features_per_image;
  return SimulateObservations(ExampleSimulatedCamera(), TestBoard(), options)
      .dataset;
}

CalibrationOptions Coarse() {
  CalibrationOptions options;
  options.knot_spacing_px = 160;
  options.num_threads = 2;
  return options;
}

CalibrationOptions HoldingOut(const std::vector<std::string>& images) {
  CalibrationOptions options = Coarse();
  options.hold_out = images;
  return options;
}

std::set<std::string> ImagesOf(const std::vector<FeatureResidual>& residuals) {
  std::set<std::string> images;
  for (const FeatureResidual& residual : residuals)
    images.insert(residual.image);
  return images;
}

TEST(Calibrate, NeedsThreeImages) {
  ExpectError(ExitCode::kInsufficientData, {"2 images"},
              [] { Calibrate(Simulate(2), TestBoard(), Coarse()); });
  ExpectError(ExitCode::kInsufficientData, {},
              [] { Calibrate(Dataset(), TestBoard(), Coarse()); });
}

TEST(Calibrate, ImagesWithFewFeaturesAreRejectedByName) {
  Dataset dataset = Simulate(6);
  dataset.images[2].features.resize(7);
  const CalibrationResult result =
      Calibrate(dataset, TestBoard(), HoldingOut({dataset.images[5].image}));
  ASSERT_EQ(result.rejected_images.size(), 1u);
  EXPECT_EQ(result.rejected_images[0].image, dataset.images[2].image);
  EXPECT_EQ(result.features.images.size(), 4u);
  EXPECT_EQ(ImagesOf(result.training).count(dataset.images[2].image), 0u);
}

TEST(Calibrate, RefusesUnknownModelsAndHeldOutImages) {
  CalibrationOptions options = Coarse();
  options.model = "pinhole";
  ExpectError(ExitCode::kUsage, {"pinhole"},
              [&] { Calibrate(Simulate(4), TestBoard(), options); });
  ExpectError(ExitCode::kUsage, {"nowhere.png"}, [] {
    Calibrate(Simulate(4), TestBoard(), HoldingOut({"nowhere.png"}));
  });
}

TEST(Calibrate, FeaturesWithoutABoardHaveNoStart) {
  Dataset dataset = Simulate(5);
  TestRandom random(1);
  for (ImageFeatures& image : dataset.images)
    for (Feature& feature : image.features)
      feature.pixel = random.PixelIn({0, 0, 639, 479});
  ExpectError(ExitCode::kInitializationFailed, {},
              [&] { Calibrate(dataset, TestBoard(), Coarse()); });
}

TEST(Calibrate, HeldOutImagesAreNotCalibratedWith) {
  const Dataset dataset = Simulate(7);
  const std::vector<std::string> names = {dataset.images[1].image,
                                          dataset.images[5].image};
  const CalibrationResult result =
      Calibrate(dataset, TestBoard(), HoldingOut(names));
  EXPECT_EQ(ImagesOf(result.held_out),
            std::set<std::string>(names.begin(), names.end()));
  EXPECT_EQ(ImagesOf(result.training).size(), 5u);
  for (const std::string& name : names)
    EXPECT_EQ(ImagesOf(result.training).count(name), 0u);
  EXPECT_FALSE(result.cross_validated);

  // Nor does it matter what is in them.
  Dataset other = dataset;
  for (Feature& feature : other.images[1].features) feature.pixel.x() += 0.5;
  CameraFile alone, other_alone;
  alone.camera = result.camera.camera;
  other_alone.camera =
      Calibrate(other, TestBoard(), HoldingOut(names)).camera.camera;
  EXPECT_EQ(FormatCameraFile(alone), FormatCameraFile(other_alone));
}

TEST(Calibrate, CrossValidationTestsEveryImage) {
  const Dataset dataset = Simulate(10);
  CalibrationOptions options = Coarse();
  options.model = "opencv";
  options.fix_target_geometry = true;
  const CalibrationResult result = Calibrate(dataset, TestBoard(), options);
  EXPECT_TRUE(result.cross_validated);
  EXPECT_EQ(ImagesOf(result.held_out).size(), 10u);
  EXPECT_EQ(result.camera.camera->Name(), "opencv");
  EXPECT_GE(result.camera.held_out->median_px,
            result.camera.training->median_px);
}

TEST(Calibrate, FlatBoardStaysAsItIs) {
  const Dataset dataset = Simulate(8);
  CalibrationOptions options = HoldingOut({dataset.images[0].image});
  options.fix_target_geometry = true;
  const CalibrationResult result = Calibrate(dataset, TestBoard(), options);
  const auto nominal = TestBoard().boards[0].points;
  for (size_t i = 0; i < nominal.size(); ++i)
    EXPECT_LT((result.pattern.boards[0].points[i] - nominal[i]).norm(), 1e-12);
}

TEST(Calibrate, GivesTheSameBytesWithAnyNumberOfThreads) {
  const Dataset dataset = Simulate(9);
  std::string cameras[2], patterns[2], poses[2];
  for (int k = 0; k < 2; ++k) {
    CalibrationOptions options;
    options.knot_spacing_px = 120;
    options.num_threads = k + 1;
    const CalibrationResult result = Calibrate(dataset, TestBoard(), options);
    cameras[k] = FormatCameraFile(result.camera);
    patterns[k] = FormatPattern(result.pattern);
    poses[k] = FormatPoses(result.poses);
  }
  EXPECT_EQ(cameras[0], cameras[1]);
  EXPECT_EQ(patterns[0], patterns[1]);
  EXPECT_EQ(poses[0], poses[1]);
}

// All that a result says.
std::string ToString(const CalibrationResult& result) {
  std::string text = FormatCameraFile(result.camera) +
                     FormatPattern(result.pattern) + FormatPoses(result.poses);
  const auto add = [&text](double value) { text += std::to_string(value); };
  for (const auto* set : {&result.training, &result.held_out})
    for (const FeatureResidual& residual : *set) add(residual.error_px.norm());
  for (const ModelMetrics& model : result.parametric_models) {
    text += model.model;
    add(model.training.rms_px);
    add(model.held_out ? model.held_out->rms_px : -1);
  }
  return text;
}

// Some twenty calibrations each time: few features, of a board that is flat,
// are enough to tell bits apart.
TEST(Calibrate, IsTheSameToTheBitWhenItWasInterrupted) {
  const Dataset dataset = Simulate(8, 40);
  int polls = 0, last_poll = 1 << 30;
  CalibrationOptions options = Coarse();
  options.knot_spacing_px = 240;
  options.fix_target_geometry = true;
  options.num_threads = 1;
  options.compare_models = true;
  CalibrationInput input = {"", dataset};
  input.refine_features = [&](const CameraModel&, const Pattern&,
                              const std::vector<BoardPose>&) {
    Dataset again = dataset;
    again.images[0].features[0].pixel.x() += 0.01;
    return again;
  };
  options.should_stop = [&] { return ++polls > last_poll; };
  const auto calibrate = [&] {
    return Calibrate({input}, TestBoard(), options).cameras.front();
  };
  const std::string whole = ToString(calibrate());
  const int all_polls = polls;
  // In the cross-validation, and among the other models; what a signal leaves,
  // and what a kill does.
  for (const double part : {0.2, 0.97}) {
    std::optional<Checkpoint> kept;
    input.keep = [&](const Checkpoint& checkpoint) { kept = checkpoint; };
    input.resume.reset();
    polls = 0;
    last_poll = static_cast<int>(part * all_polls);
    const CalibrationResult first = calibrate();
    ASSERT_TRUE(first.checkpoint && kept) << part;
    ASSERT_FALSE(first.checkpoint->trials.empty()) << part;
    ASSERT_EQ(first.checkpoint->trials.size() < 4, part < 0.5) << part;
    last_poll = 1 << 30;
    input.resume = part < 0.5 ? kept : first.checkpoint;
    EXPECT_EQ(ToString(calibrate()), whole) << part;
  }
}

TEST(Calibrate, GoesOnWithTheFeaturesMeasuredAgain) {
  SimulationOptions exact;
  exact.num_images = 6;
  exact.features_per_image = 80;
  exact.noise_px = 0;
  const Dataset truth =
      SimulateObservations(ExampleSimulatedCamera(), TestBoard(), exact)
          .dataset;
  const Dataset noisy = Simulate(6);
  const std::string held_out = noisy.images[4].image;
  CalibrationOptions options = HoldingOut({held_out});
  options.knot_spacing_px =
      60;  // else the lens's bumps are most of what is left
  options.fix_target_geometry = true;
  const CalibrationResult once = Calibrate(noisy, TestBoard(), options);
  int num_calls = 0;
  CalibrationInput input = {"", noisy};
  input.refine_features = [&](const CameraModel& camera, const Pattern& pattern,
                              const std::vector<BoardPose>& poses) {
    ++num_calls;
    EXPECT_EQ(camera.Name(), "central-generic");
    EXPECT_EQ(pattern.boards[0].points.size(), 140u);
    EXPECT_EQ(poses.size(), 6u);  // also of the image held out
    return truth;
  };
  const CalibrationResult again =
      Calibrate({input}, TestBoard(), options).cameras.front();
  EXPECT_EQ(num_calls, 1);
  EXPECT_FALSE(once.refinement_rms_px);
  EXPECT_NEAR(*again.refinement_rms_px, 0.05 * std::sqrt(2), 0.005);
  EXPECT_LT(again.camera.training->rms_px, 0.5 * once.camera.training->rms_px);
  EXPECT_LT(again.camera.held_out->rms_px, 0.5 * once.camera.held_out->rms_px);
}

TEST(Calibrate, ProgressGrowsFromZeroToOne) {
  const Dataset dataset = Simulate(9);
  CalibrationOptions options = Coarse();
  options.fix_target_geometry = true;
  std::vector<double> done;
  options.progress = [&](const std::string&, double d) { done.push_back(d); };
  Calibrate(dataset, TestBoard(), options);
  EXPECT_EQ(done.front(), 0);
  EXPECT_EQ(done.back(), 1);
  EXPECT_TRUE(std::is_sorted(done.begin(), done.end()));
}

// Its axis is nowhere near the middle, and its pixels are not square.
TEST(Calibrate, NeedsNoHintForAPartOfAFisheyesImage) {
  ThinPrismFisheye::ParameterArray parameters = {};
  parameters[ThinPrismFisheye::kFx] = 380;
  parameters[ThinPrismFisheye::kFy] = 300;
  parameters[ThinPrismFisheye::kCx] = -60;
  parameters[ThinPrismFisheye::kCy] = 20;
  const ThinPrismFisheye lens({640, 480}, {-1, -1, 640, 480}, parameters);
  SimulationOptions simulation;
  simulation.num_images = 30;
  simulation.features_per_image = 80;
  const Dataset dataset =
      SimulateObservations(lens, TestBoard(), simulation).dataset;
  const CalibrationResult result =
      Calibrate(dataset, TestBoard(), HoldingOut({dataset.images[7].image}));
  EXPECT_LT(CompareModels(lens, *result.camera.camera, 16).median_px, 0.05);
}

TEST(Calibrate, AreaIsThatOfTheFeatures) {
  const Dataset dataset = Simulate(8);
  const CalibrationResult result =
      Calibrate(dataset, TestBoard(), HoldingOut({dataset.images[7].image}));
  const Area& area = result.camera.camera->area();
  for (const ImageFeatures& image : result.features.images)
    for (const Feature& feature : image.features)
      EXPECT_TRUE(area.Contains(feature.pixel));
  EXPECT_LT(area.width(), 640);
  EXPECT_GT(area.width(), 500);
}

TEST(Calibrate, TrustsNoCellThatTheImageCircleCuts) {
  const Dataset dataset = Simulate(24, 120);
  const ImageCircle circle = {{310, 250}, {200, 200}};
  CalibrationInput input{"", dataset};
  input.image_circle = circle;
  CalibrationOptions options = HoldingOut({dataset.images[7].image});
  const CalibrationResult with =
      Calibrate({input}, TestBoard(), options).cameras.front();
  const CalibrationResult without = Calibrate(dataset, TestBoard(), options);
  EXPECT_EQ(with.camera.camera->Parameters(),
            without.camera.camera->Parameters());
  ASSERT_TRUE(with.camera.camera->image_circle());
  EXPECT_FALSE(without.camera.camera->image_circle());
  const ValidityMask& mask = with.camera.uncertainty->mask;
  const ValidityMask& all = without.camera.uncertainty->mask;
  int num_distrusted = 0;
  for (int cell = 0; cell < mask.columns * mask.rows; ++cell) {
    const double distance_px = (mask.CellCenter(cell) - circle.center).norm();
    const double half_diagonal_px = mask.knot_spacing_px * std::sqrt(0.5);
    if (distance_px < 200 - half_diagonal_px) {
      EXPECT_EQ(mask.is_valid[cell], all.is_valid[cell]);
    }
    if (distance_px <= 200) continue;
    EXPECT_FALSE(mask.is_valid[cell]);
    num_distrusted += all.is_valid[cell];
  }
  EXPECT_GT(num_distrusted, 50);
}

// A pinhole-like lens behind an aquarium's wall.
CoverGlassCamera LensBehindGlass() {
  GlassPlate plate;
  plate.thickness_m = 0.02;
  return CoverGlassCamera(*MakeSimulatedCamera("pinhole", {640, 480}), plate);
}

CalibrationResult CalibrateSeenBy(const CameraModel& lens,
                                  const std::string& model,
                                  int num_images = 24) {
  SimulationOptions simulation;
  simulation.num_images = num_images;
  simulation.features_per_image = 100;
  const Dataset dataset =
      SimulateObservations(lens, TestBoard(), simulation).dataset;
  CalibrationOptions options = HoldingOut({});
  for (size_t i = 0; i < dataset.images.size(); i += 4)
    options.hold_out.push_back(dataset.images[i].image);
  options.model = model;
  options.num_threads = 1;
  return Calibrate(dataset, TestBoard(), options);
}

constexpr double kNoiseRmsPx = 0.05 * M_SQRT2;

TEST(Calibrate, OnlyLinesExplainWhatIsSeenThroughGlass) {
  const CoverGlassCamera lens = LensBehindGlass();
  const CalibrationResult central = CalibrateSeenBy(lens, "central-generic");
  const CalibrationResult lines = CalibrateSeenBy(lens, "noncentral-generic");
  EXPECT_GT(central.camera.held_out->rms_px, 2 * kNoiseRmsPx);
  EXPECT_LT(lines.camera.held_out->rms_px, 1.2 * kNoiseRmsPx);
  EXPECT_FALSE(central.noncentrality);
  ASSERT_TRUE(lines.noncentrality);
  const Noncentrality truth = ComputeNoncentrality(lens);
  EXPECT_NEAR(lines.noncentrality->rms_m, truth.rms_m, 0.1 * truth.rms_m);
  // The frame's origin is where the lines come nearest.
  EXPECT_LT(lines.noncentrality->nearest_point.norm(), 1e-9);
  EXPECT_LT(CompareModels(lens, *lines.camera.camera, 16, 0.5).rms_px,
            0.25 * CompareModels(lens, *central.camera.camera, 16, 0.5).rms_px);
}

TEST(Calibrate, AdjustsEveryModel) {
  for (const std::string& model : ListCalibratedModels()) {
    const auto lens = MakeSimulatedCamera(
        model == "opencv" ? "pinhole" : "fisheye", {640, 480});
    const CalibrationResult result = CalibrateSeenBy(*lens, model, 12);
    EXPECT_EQ(result.camera.camera->Name(), model);
    // The parametric ones lack the lens's local bends.
    EXPECT_LT(result.camera.held_out->median_px, 0.3) << model;
  }
}

TEST(Calibrate, LinesOfACentralLensMeet) {
  const auto lens = MakeSimulatedCamera("pinhole", {640, 480});
  const CalibrationResult lines = CalibrateSeenBy(*lens, "noncentral-generic");
  EXPECT_LT(lines.camera.held_out->rms_px, 1.1 * kNoiseRmsPx);
  EXPECT_LT(lines.noncentrality->rms_m, 2e-5);
}

// With noise, from where the boards are given to be; every third feature.
Dataset Observe(const std::vector<Pose>& poses) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  Board board = TestBoard().boards[0];
  board.points = board.NominalPoints();
  TestRandom random(7);
  Dataset dataset;
  dataset.image_size = camera.image_size();
  for (const Pose& pose : poses) {
    const std::string name =
        "view" + std::to_string(dataset.images.size()) + ".png";
    dataset.images.push_back({name, {}});
    for (Feature& feature : VisibleFeatures(camera, board, pose)) {
      if ((feature.column + feature.row) % 3 != 0) continue;
      feature.pixel += 0.05 * random.NormalVector<2>();
      dataset.images.back().features.push_back(feature);
    }
  }
  return dataset;
}

Pose PoseOver(double x_m, double y_m, double z_m, double tilt_rad) {
  Pose pose;
  pose.rotation = Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitX());
  pose.translation = {x_m - 0.2, y_m - 0.15, z_m};
  return pose;
}

bool HasReason(const CalibrationResult& result, const std::string& words) {
  const auto& reasons = result.assessment.reasons;
  return std::any_of(reasons.begin(), reasons.end(),
                     [&](const std::string& reason) {
                       return reason.find(words) != std::string::npos;
                     });
}

// Verdicts of views: one is held out, since cross-validation would adjust what
// hardly converges four times more.
TEST(Calibrate, FailsWhereNoBoardIsTilted) {
  std::vector<Pose> poses;
  for (int k = 0; k < 12; ++k)
    poses.push_back(
        PoseOver(0.1 * (k % 3 - 1), 0.1 * (k / 3 % 2), 0.5 + 0.05 * k, 0));
  const CalibrationResult result =
      Calibrate(Observe(poses), TestBoard(), HoldingOut({"view11.png"}));
  EXPECT_EQ(result.assessment.word, "fail");
  EXPECT_TRUE(
      HasReason(result, "the target has the same orientation in all images"));
}

TEST(Calibrate, FailsWherePixelsAreLikeNoCameras) {
  Dataset dataset = Simulate(8);
  dataset.image_size.height = 48;
  for (ImageFeatures& image : dataset.images)
    for (Feature& feature : image.features)
      feature.pixel.y() = (feature.pixel.y() + 0.5) / 10 - 0.5;
  const CalibrationResult result =
      Calibrate(dataset, TestBoard(), HoldingOut({dataset.images[7].image}));
  EXPECT_EQ(result.assessment.word, "fail");
  EXPECT_TRUE(HasReason(result, "pixel aspect ratio"));
}

TEST(Calibrate, FailsWhereAllViewsAreTheSame) {
  const CalibrationResult result =
      Calibrate(Observe(std::vector<Pose>(12, PoseOver(0, 0, 0.5, 0.6))),
                TestBoard(), HoldingOut({"view11.png"}));
  EXPECT_EQ(result.assessment.word, "fail");
  EXPECT_TRUE(HasReason(result, "images show only 1 different view of"));
}

TEST(Calibrate, NamesImagesOfAnotherCamera) {
  Dataset dataset = Simulate(20);
  for (const int k : {4, 11})
    for (Feature& feature : dataset.images[k].features)
      feature.pixel = {feature.pixel.x(), 0.8 * feature.pixel.y()};
  const CalibrationResult result = Calibrate(dataset, TestBoard(), Coarse());
  EXPECT_EQ(result.assessment.word, "warn");
  EXPECT_TRUE(HasReason(result, "2 images (" + dataset.images[4].image +
                                    ", ...) are inconsistent"));
}

// Two images show a side that the others cannot predict.
TEST(Calibrate, KeepsImagesThatAloneShowASide) {
  SimulationOptions simulation;
  simulation.num_images = 18;
  simulation.features_per_image = 100;
  simulation.noise_px = 0.01;
  Dataset dataset =
      SimulateObservations(ExampleSimulatedCamera(), TestBoard(), simulation)
          .dataset;
  const auto is_right = [](const Feature& feature) {
    return feature.pixel.x() > 420;
  };
  const auto num_right = [&](const ImageFeatures& image) {
    return std::count_if(image.features.begin(), image.features.end(),
                         is_right);
  };
  std::stable_sort(dataset.images.begin(), dataset.images.end(),
                   [&](const ImageFeatures& a, const ImageFeatures& b) {
                     return num_right(a) < num_right(b);
                   });
  for (size_t i = 0; i + 2 < dataset.images.size(); ++i) {
    auto& features = dataset.images[i].features;
    features.erase(std::remove_if(features.begin(), features.end(), is_right),
                   features.end());
  }
  const CalibrationResult result = Calibrate(dataset, TestBoard(), Coarse());
  EXPECT_FALSE(result.unique_coverage_images.empty());
  EXPECT_TRUE(HasReason(result, "of the image is covered by"));
  EXPECT_FALSE(HasReason(result, "are inconsistent with the others"));
}

TEST(Calibrate, NamesAMirroredPattern) {
  Dataset dataset = Simulate(12);
  for (ImageFeatures& image : dataset.images)
    for (Feature& feature : image.features)
      feature.column = 13 - feature.column;
  const CalibrationResult result = Calibrate(dataset, TestBoard(), Coarse());
  EXPECT_TRUE(HasReason(result, "seen from behind in 12 of 12 views"));
}

TEST(Calibrate, NamesAFewMirroredImages) {
  Dataset dataset = Simulate(12);
  for (const int k : {3, 8})
    for (Feature& feature : dataset.images[k].features)
      feature.column = 13 - feature.column;
  const CalibrationResult result = Calibrate(dataset, TestBoard(), Coarse());
  EXPECT_EQ(result.assessment.word, "warn");
  EXPECT_TRUE(HasReason(result, "seen from behind in 2 of 12 views (" +
                                    dataset.images[3].image + ", ...)"));
}

// The board's positions as points alone, this far from their plane.
Pattern PointsOfTestBoard(double depth_m) {
  Pattern pattern = TestBoard();
  Board& board = pattern.boards[0];
  board.kind = "points";
  TestRandom random(3);
  for (Eigen::Vector3d& point : board.points)
    point.z() = random.Uniform(-depth_m, depth_m);
  return pattern;
}

TEST(Calibrate, PassesBoardsOfPoints) {
  ThinPrismFisheye::ParameterArray parameters = {};
  parameters[ThinPrismFisheye::kFx] = parameters[ThinPrismFisheye::kFy] = 380;
  parameters[ThinPrismFisheye::kCx] = 320;
  parameters[ThinPrismFisheye::kCy] = 240;
  const ThinPrismFisheye lens({640, 480}, {-1, -1, 640, 480}, parameters);
  SimulationOptions simulation;
  simulation.num_images = 20;
  simulation.features_per_image = 100;
  CalibrationOptions options;
  options.model = "thin-prism-fisheye";
  options.fix_target_geometry = true;
  options.num_threads = 2;
  for (const double depth_m : {0.0, 0.05}) {
    const Pattern pattern = PointsOfTestBoard(depth_m);
    const CalibrationResult result =
        Calibrate(SimulateObservations(lens, pattern, simulation).dataset,
                  pattern, options);
    EXPECT_EQ(result.assessment.word, "pass")
        << testing::PrintToString(result.assessment.reasons);
    EXPECT_EQ(result.fold_over.part, 0);
  }
}

TEST(Calibrate, FailsWhereNoFlatBoardOfPointsIsTilted) {
  std::vector<Pose> poses;
  for (int k = 0; k < 12; ++k)
    poses.push_back(
        PoseOver(0.1 * (k % 3 - 1), 0.1 * (k / 3 % 2), 0.5 + 0.05 * k, 0));
  const CalibrationResult result = Calibrate(
      Observe(poses), PointsOfTestBoard(0), HoldingOut({"view11.png"}));
  EXPECT_EQ(result.assessment.word, "fail");
  EXPECT_TRUE(
      HasReason(result, "the target has the same orientation in all images"));
}

TEST(EvaluateCamera, FindsTheNoiseOfATrueCamera) {
  const Dataset dataset = Simulate(10);
  const Evaluation evaluation =
      EvaluateCamera(ExampleSimulatedCamera(), dataset, TestBoard(), 2);
  EXPECT_TRUE(evaluation.rejected_images.empty());
  EXPECT_EQ(evaluation.residuals.size() + evaluation.outside_area, 800u);
  const ErrorMetrics metrics = ComputeErrorMetrics(evaluation.residuals);
  EXPECT_NEAR(metrics.rms_px, 0.05 * std::sqrt(2.0), 0.007);
}

TEST(EvaluateCamera, CountsFeaturesOutsideTheArea) {
  const Dataset dataset = Simulate(10);
  const CentralGeneric inner =
      FitCentralGeneric(ExampleSimulatedCamera(), {100, 100, 500, 400}, 13, 11);
  const Evaluation evaluation = EvaluateCamera(inner, dataset, TestBoard(), 1);
  int inside = 0;
  for (const ImageFeatures& image : dataset.images)
    for (const Feature& feature : image.features)
      inside += inner.area().Contains(feature.pixel);
  EXPECT_GT(evaluation.outside_area, 50);
  EXPECT_LE(evaluation.residuals.size(), static_cast<size_t>(inside));
  EXPECT_GE(evaluation.residuals.size(), 0.95 * inside);
}

}  // namespace
}  // namespace raygrid
