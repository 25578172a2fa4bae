// The camera that a calibration finds, against the truth that it was simulated
// with.

#include <cstdio>
#include <map>

#include "calibration/calibration.h"
#include "calibration/camera_evaluation.h"
#include "evaluation/model_difference.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_observations.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

SimulatedObservations Simulate(int num_images, double bend_m = 0) {
  SimulationOptions options;
  options.num_images = num_images;
  options.board_sagitta_m = bend_m;
  return SimulateObservations(ExampleSimulatedCamera(), FineTestBoard(),
                              options);
}

// One image held out saves the time of cross-validation.
CalibrationOptions WithCells(const Dataset& dataset, double knot_spacing_px) {
  CalibrationOptions options;
  options.knot_spacing_px = knot_spacing_px;
  options.hold_out = {dataset.images.back().image};
  return options;
}

CalibrationResult CalibrateWithCells(const Dataset& dataset,
                                     double knot_spacing_px) {
  return Calibrate(dataset, FineTestBoard(),
                   WithCells(dataset, knot_spacing_px));
}

ModelDifference Truth(const char* what, const CalibrationResult& result) {
  const ModelDifference difference =
      CompareModels(ExampleSimulatedCamera(), *result.camera.camera, 4);
  std::printf(
      "%s: ray error median %.4f px, RMS %.4f, 99 %% %.4f, max %.4f; training "
      "median %.4f px\n",
      what, difference.median_px, difference.rms_px, difference.p99_px,
      difference.max_px, result.camera.training->median_px);
  return difference;
}

double Rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

TEST(Accuracy, HundredImagesGiveTheTrueRays) {
  const CalibrationResult result =
      CalibrateWithCells(Simulate(100).dataset, 40);
  EXPECT_TRUE(result.converged);
  const ModelDifference difference = Truth("100 images", result);
  EXPECT_GT(difference.pixels.size(), 15000u);
  EXPECT_LE(difference.median_px, 0.0070);
  EXPECT_LE(difference.max_px, 0.15);

  // And how well they are known.
  ASSERT_TRUE(result.camera.uncertainty);
  const CameraUncertainty& known = *result.camera.uncertainty;
  const Area& area = result.camera.camera->area();
  EXPECT_GT(known.ValidFraction({640, 480}, area), 0.9);
  std::vector<double> errors, deviations, scatters;
  for (size_t i = 0; i < difference.pixels.size(); ++i) {
    if (!known.mask.IsValidAt(difference.pixels[i])) continue;
    errors.push_back(difference.error_px[i].norm());
    deviations.push_back(known.lattice.At(area, difference.pixels[i]));
    scatters.push_back(known.scatter.At(area, difference.pixels[i]));
    EXPECT_LE(scatters.back(), deviations.back());
  }
  const double error = Rms(errors), deviation = Rms(deviations);
  std::printf(
      "trusted area: RMS error %.4f px, worst %.3f px; standard deviation, RMS "
      "%.4f px\n",
      error, Quantile(errors, 1), deviation);
  EXPECT_LE(Quantile(errors, 1), 0.1);
  EXPECT_LE(Quantile(deviations, 1), known.max_stddev_px);
  // One draw of the noise: the few smooth directions that are known least do
  // not average out.
  EXPECT_LE(error, 2 * deviation);
  EXPECT_GE(error, 0.5 * deviation);
  EXPECT_GE(Rms(scatters), 0.5 * deviation);
}

// Root mean square distance of corresponding points.
double RmsDistance(const std::vector<Eigen::Vector3d>& a,
                   const std::vector<Eigen::Vector3d>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

// The points moved by the similarity that brings them nearest to others.
std::vector<Eigen::Vector3d> SimilarityAligned(
    const std::vector<Eigen::Vector3d>& points,
    const std::vector<Eigen::Vector3d>& to) {
  Eigen::Matrix3Xd from(3, points.size()), target(3, points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    from.col(i) = points[i];
    target.col(i) = to[i];
  }
  const Eigen::Matrix4d similarity = Eigen::umeyama(from, target, true);
  std::vector<Eigen::Vector3d> aligned;
  for (const Eigen::Vector3d& point : points)
    aligned.push_back((similarity * point.homogeneous()).head<3>());
  return aligned;
}

TEST(Accuracy, BentBoardIsRecovered) {
  const SimulatedObservations simulated = Simulate(60, 0.003);
  const CalibrationResult result = CalibrateWithCells(simulated.dataset, 40);
  const std::vector<Eigen::Vector3d>& found = result.pattern.boards[0].points;
  const std::vector<Eigen::Vector3d>& truth =
      simulated.true_pattern.boards[0].points;
  const double flat = RmsDistance(
      SimilarityAligned(FineTestBoard().boards[0].points, truth), truth);
  const double error = RmsDistance(SimilarityAligned(found, truth), truth);
  std::printf("bent board: %.1f um RMS from flat, found to %.1f um\n",
              1e6 * flat, 1e6 * error);
  EXPECT_GT(flat, 300e-6);
  EXPECT_LT(error, 0.05 * flat);
  EXPECT_LT(Truth("bent board", result).median_px, 0.02);
}

// Median error of images that were not calibrated with, without noise.
double HeldOutOnTruth(const CalibrationResult& result) {
  SimulationOptions options;
  options.num_images = 30;
  options.noise_px = 0;
  options.seed = 77;
  const SimulatedObservations test =
      SimulateObservations(ExampleSimulatedCamera(), FineTestBoard(), options);
  const Evaluation evaluation =
      EvaluateCamera(*result.camera.camera, test.dataset, result.pattern, 0);
  EXPECT_GT(evaluation.residuals.size(), 5000u);
  return ComputeErrorMetrics(evaluation.residuals).median_px;
}

// The board is flat, and told so: that saves half a minute.
double HeldOutOnTruthWith(const Dataset& dataset, const std::string& model,
                          double knot_spacing_px) {
  CalibrationOptions options = WithCells(dataset, knot_spacing_px);
  options.model = model;
  options.fix_target_geometry = true;
  return HeldOutOnTruth(Calibrate(dataset, FineTestBoard(), options));
}

// 1,782 parameters from 1,440 features: the prior must hold what they do not.
TEST(Accuracy, FewImagesDoNotWreckAFineGrid) {
  const Dataset dataset = Simulate(7).dataset;  // one of them held out
  const double fine = HeldOutOnTruthWith(dataset, "central-generic", 20);
  const double coarse = HeldOutOnTruthWith(dataset, "central-generic", 80);
  const double parametric = HeldOutOnTruthWith(dataset, "opencv", 0);
  std::printf(
      "6 images: held-out median %.4f px with 20 px cells, %.4f with 80 px, "
      "%.4f with 12 parameters\n",
      fine, coarse, parametric);
  EXPECT_LE(fine, 1.35 * coarse);
  EXPECT_LE(fine, 0.25 * parametric);
}

// Moves a part of the features by 10 to 30 px; returns how many.
int Displace(double part, Dataset* dataset) {
  TestRandom random(5);
  int count = 0;
  for (ImageFeatures& image : dataset->images) {
    for (Feature& feature : image.features) {
      if (random.Uniform(0, 1) >= part) continue;
      const double angle = random.Uniform(0, 2 * M_PI);
      const Eigen::Vector2d moved =
          feature.pixel + random.Uniform(10, 30) *
                              Eigen::Vector2d(std::cos(angle), std::sin(angle));
      if (!WholeImage(dataset->image_size).Contains(moved)) continue;
      feature.pixel = moved;
      ++count;
    }
  }
  return count;
}

TEST(Accuracy, DisplacedFeaturesAreRejectedAndDoLittleHarm) {
  Dataset dataset = Simulate(24).dataset;
  const ModelDifference clean =
      Truth("without outliers", CalibrateWithCells(dataset, 40));
  const int num_displaced = Displace(0.02, &dataset);
  ASSERT_GT(num_displaced, 90);
  const CalibrationResult result = CalibrateWithCells(dataset, 40);
  const ModelDifference difference = Truth("2 % outliers", result);
  int num_rejected = 0;
  for (const FeatureResidual& feature : result.rejected_features)
    num_rejected += feature.error_px.norm() > 5;
  std::printf("%d displaced, %zu rejected, %d of these by more than 5 px\n",
              num_displaced, result.rejected_features.size(), num_rejected);
  // All but those of the image held out, about one in 24.
  EXPECT_GT(num_rejected, 0.95 * num_displaced);
  EXPECT_LE(result.rejected_features.size(), 1.1 * num_displaced);
  EXPECT_LT(difference.median_px, 1.3 * clean.median_px);
}

CalibrationResult CalibrateBendingBoards(uint64_t seed) {
  SimulationOptions simulation;
  simulation.num_images = 100;
  simulation.features_per_image = 17 * 11;
  simulation.noise_px = 0.02;
  simulation.board_deformation_m = 0.0001;
  simulation.seed = seed;
  const Pattern pattern = ChessboardPattern(17, 11, 0.024);
  CalibrationOptions options;
  options.num_threads = 2;
  return Calibrate(
      SimulateObservations(ExampleSimulatedCamera(), pattern, simulation)
          .dataset,
      pattern, options);
}

// The bends of held-out boards hid here that a camera with bends is better.
TEST(Accuracy, FollowsBendsThatHeldOutBoardsHide) {
  EXPECT_TRUE(CalibrateBendingBoards(23).bends.has_value());
}

// To rigid boards bends are noise, of which coarser cells take less.
TEST(Accuracy, ChoosesCellsByBoardsThatBend) {
  const CalibrationResult result = CalibrateBendingBoards(1);
  ASSERT_TRUE(result.bends.has_value());
  std::map<double, double> loss_by_rigid_boards;
  for (const KnotSpacingCandidate& tried : result.knot_spacing_candidates)
    loss_by_rigid_boards[tried.knot_spacing_px] = tried.loss;
  EXPECT_LT(loss_by_rigid_boards.at(80), loss_by_rigid_boards.at(40));
  EXPECT_EQ(result.knot_spacing_px, 40);
}

}  // namespace
}  // namespace raygrid
