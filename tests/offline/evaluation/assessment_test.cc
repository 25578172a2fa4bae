#include "evaluation/assessment.h"

#include <algorithm>

#include "support.h"

namespace raygrid {
namespace {

CalibrationMetrics GoodFigures() {
  CalibrationMetrics metrics;
  metrics.tried.model = "central-generic";
  metrics.converged = true;
  metrics.image_size = {640, 480};
  metrics.features_area = {10, 10, 630, 470};
  metrics.images_used = 30;
  metrics.training = {0.10, 0.12, 0.8, 3000};
  metrics.held_out = {0.11, 0.13, 0.9, 3000};
  metrics.boards_seen = metrics.different_views = 30;
  metrics.tilt_rad = 0.8;
  metrics.median_stddev_px = 0.02;
  metrics.valid_share = 0.95;
  metrics.valid_limit_px = 0.3;
  metrics.extrapolated = {0.02, 0.1, "corners"};
  return metrics;
}

bool HasReason(const Assessment& assessment, const std::string& words) {
  return std::any_of(assessment.reasons.begin(), assessment.reasons.end(),
                     [&](const std::string& reason) {
                       return reason.find(words) != std::string::npos;
                     });
}

TEST(Assessment, PassesGoodFigures) {
  const Assessment assessment = AssessCalibration(GoodFigures());
  EXPECT_EQ(assessment.word, "pass");
  EXPECT_TRUE(assessment.reasons.empty());
}

// Features of images of half the size lie in a quarter of the image.
TEST(Assessment, DoubtsTheImageSizeOfFeaturesInAQuarter) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.features_area = {5, 5, 317, 238};
  EXPECT_TRUE(HasReason(AssessCalibration(metrics), "check --image-size"));
  metrics.features_area = {5, 5, 317, 400};
  const Assessment assessment = AssessCalibration(metrics);
  EXPECT_FALSE(HasReason(assessment, "check --image-size"));
  EXPECT_TRUE(HasReason(assessment, "move the target into the corners"));
}

TEST(Assessment, TellsAStrangerAmongAFleet) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.fleet_distance = FleetDistance{1.2, 0.3};
  EXPECT_EQ(AssessCalibration(metrics).word, "pass");
  metrics.fleet_distance = FleetDistance{4.1, 0.3};
  const Assessment assessment = AssessCalibration(metrics);
  EXPECT_EQ(assessment.word, "warn");
  EXPECT_TRUE(HasReason(assessment, "4.1 px RMS from the population mean"));
}

TEST(Assessment, FailsWhatDidNotConverge) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.converged = false;
  EXPECT_EQ(AssessCalibration(metrics).word, "fail");
}

TEST(Assessment, FailsLargeHeldOutErrors) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.training.median_px = metrics.held_out->median_px = 2.5;
  EXPECT_EQ(AssessCalibration(metrics).word, "fail");
}

TEST(Assessment, FailsViewsThatLeaveTheCameraOpen) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.median_stddev_px = 15;
  metrics.valid_share = 0;
  const Assessment assessment = AssessCalibration(metrics);
  EXPECT_EQ(assessment.word, "fail");
  ASSERT_EQ(assessment.reasons.size(), 1u);
  EXPECT_EQ(
      assessment.reasons[0].find("the views constrain the camera too weakly: "
                                 "expect errors of 15 px"),
      0u);
}

TEST(Assessment, FailsBoardsThatAreAllParallel) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.tilt_rad = 0.02;
  EXPECT_EQ(AssessCalibration(metrics).word, "fail");
}

TEST(Assessment, PointsInSpaceNeedNoTilt) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.tilt_rad.reset();
  EXPECT_EQ(AssessCalibration(metrics).word, "pass");
}

TEST(Assessment, AnInterruptedCalibrationSaysOnlyThat) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.converged = false;
  metrics.interrupted = true;
  metrics.neighbor_correlation = 0.9;
  metrics.held_out.reset();
  metrics.median_stddev_px.reset();
  metrics.valid_share.reset();
  metrics.valid_limit_px.reset();
  metrics.extrapolated.reset();
  const Assessment assessment = AssessCalibration(metrics);
  EXPECT_EQ(assessment.word, "fail");
  ASSERT_EQ(assessment.reasons.size(), 1u);
  EXPECT_EQ(assessment.reasons[0],
            "interrupted before completion; continue with --resume");
}

TEST(Assessment, FailsValidPixelsThatFoldOver) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.fold_over = {0.008, 0.001};
  const Assessment assessment = AssessCalibration(metrics);
  EXPECT_EQ(assessment.word, "fail");
  EXPECT_TRUE(
      HasReason(assessment, "is not injective within the valid region (0.1 %"));
}

TEST(Assessment, RemarksOnOtherPixelsThatFoldOver) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.fold_over = {0.008, 0};
  const Assessment assessment = AssessCalibration(metrics);
  EXPECT_EQ(assessment.word, "pass");
  EXPECT_TRUE(HasReason(assessment,
                        "is not injective outside the valid region (0.8 %"));
}

TEST(Assessment, NamesImagesFromBehindHoweverFew) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.mirrored_images = {"a.png", "b.png"};
  EXPECT_TRUE(HasReason(
      AssessCalibration(metrics),
      "the target is seen from behind in 2 of 30 views (a.png, ...)"));
}

TEST(Assessment, FailsIfManyButNotAllImagesAreMirrored) {
  CalibrationMetrics metrics = GoodFigures();
  for (const auto& [count, word] :
       {std::pair(7, "warn"), {8, "fail"}, {29, "fail"}, {30, "warn"}}) {
    metrics.mirrored_images.assign(count, "a.png");
    EXPECT_EQ(AssessCalibration(metrics).word, word) << count;
  }
}

TEST(Assessment, SuspectsThePatternWhereMostImagesHaveTooFewFeatures) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.images_rejected = 40;
  metrics.images_with_too_few_features = 36;
  EXPECT_TRUE(HasReason(AssessCalibration(metrics),
                        "36 of 70 images have too few features; check the "
                        "pattern's columns and rows"));
  metrics.images_with_too_few_features = 35;
  EXPECT_TRUE(
      HasReason(AssessCalibration(metrics), "40 of 70 images were rejected"));
}

TEST(Assessment, WarnsOfImagesOfTwoCameras) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.neighbor_correlation = 0.6;
  metrics.mixed_cameras = {{"left1.png", "left2.png"}, {"right1.png"}};
  const Assessment assessment = AssessCalibration(metrics);
  EXPECT_EQ(assessment.word, "warn");
  ASSERT_EQ(assessment.reasons.size(), 1u);
  EXPECT_TRUE(HasReason(assessment,
                        "these images appear to come from two cameras, or "
                        "from one whose focus changed: 2 images (left1.png, "
                        "...) and 1 image (right1.png); "));
}

TEST(Assessment, ReportsTransformedImages) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.transformed_images = {
      TransformedImages::Kind::kScaled, 0.5, {"a.png", "b.png"}, 20};
  Assessment assessment = AssessCalibration(metrics);
  EXPECT_EQ(assessment.word, "warn");
  EXPECT_TRUE(HasReason(
      assessment,
      "2 of 20 images (a.png, ...) are scaled by 0.5 (another resolution) "
      "relative to the others; "));
  metrics.transformed_images->num_images = 8;
  EXPECT_EQ(AssessCalibration(metrics).word, "fail");
}

TEST(Assessment, SuspectsSeveralCamerasWhereNearlyAllErrorIsShared) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.neighbor_correlation = 0.95;
  EXPECT_TRUE(
      HasReason(AssessCalibration(metrics), "images of several cameras"));
  metrics.neighbor_correlation = 0.6;
  EXPECT_FALSE(
      HasReason(AssessCalibration(metrics), "images of several cameras"));
}

TEST(Assessment, AdvisesNoModelThatIsInUse) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.neighbor_correlation = 0.6;
  EXPECT_TRUE(HasReason(AssessCalibration(metrics), "noncentral-generic"));
  metrics.tried.model = "noncentral-generic";
  EXPECT_FALSE(HasReason(AssessCalibration(metrics), "noncentral-generic"));
  EXPECT_TRUE(HasReason(AssessCalibration(metrics), "--knot-spacing-px auto"));
  metrics.tried.model = "opencv";
  EXPECT_TRUE(HasReason(AssessCalibration(metrics), "central-generic"));
  EXPECT_FALSE(
      HasReason(AssessCalibration(metrics), "smaller --knot-spacing-px"));
}

TEST(Assessment, AdvisesNothingThatWasTried) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.neighbor_correlation = 0.6;
  metrics.tried.knot_spacing_selected = true;
  metrics.tried.knot_spacing_px = 26.8;
  EXPECT_TRUE(HasReason(AssessCalibration(metrics), "--knot-spacing-px 13"));
  metrics.tried.has_tried_finer_grid = true;
  EXPECT_FALSE(HasReason(AssessCalibration(metrics), "cells"));
  EXPECT_TRUE(HasReason(AssessCalibration(metrics), "noncentral-generic"));
  metrics.tried.has_tried_noncentral_model = true;
  EXPECT_FALSE(HasReason(AssessCalibration(metrics), "noncentral-generic"));
  EXPECT_TRUE(HasReason(AssessCalibration(metrics), "are no better"));
}

TEST(Assessment, SendsNobodyFromModelToModelAndBack) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.tried.model = "opencv";
  metrics.neighbor_correlation = 0.6;
  metrics.tried.has_tried_generic_model = true;
  EXPECT_FALSE(
      HasReason(AssessCalibration(metrics), "--model central-generic"));
  metrics.better_model = {"central-generic", 0.1, 0.11};
  metrics.tried.better_model = "central-generic";
  EXPECT_TRUE(HasReason(AssessCalibration(metrics), "--model central-generic"));
}

// Whichever other advice there would be.
TEST(Assessment, AdvisesWhatTheCauseOfResidualsAsksFor) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.neighbor_correlation = 0.6;
  metrics.held_out->median_px = metrics.training.median_px = 0.5;
  metrics.limit = {"rolling shutter", "errors grow from row to row",
                   "keep still"};
  const Assessment assessment = AssessCalibration(metrics);
  ASSERT_EQ(assessment.reasons.size(), 2u);
  EXPECT_EQ(assessment.reasons[0],
            "the median held-out error is 0.5 px; the remedy for systematic "
            "errors reduces it, too");
  EXPECT_EQ(assessment.reasons[1],
            "systematic errors of about 0.1 px (neighbouring residuals are "
            "correlated: 0.60): errors grow from row to row; keep still");
  metrics.neighbor_correlation = 0;
  const Assessment alone = AssessCalibration(metrics);
  ASSERT_EQ(alone.reasons.size(), 1u);
  EXPECT_EQ(alone.reasons[0],
            "the median held-out error is 0.5 px: errors grow from row to row; "
            "keep still");
}

TEST(Assessment, NoiseThatIsToldBlamesNoBoard) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.held_out->median_px = metrics.training.median_px = 0.5;
  EXPECT_TRUE(HasReason(AssessCalibration(metrics), "flatter target"));
  metrics.limit = {"noise", "feature noise", "take sharper images"};
  EXPECT_FALSE(HasReason(AssessCalibration(metrics), "flatter target"));
  EXPECT_TRUE(HasReason(AssessCalibration(metrics), "take sharper images"));
  // Neighbours are another matter.
  metrics.neighbor_correlation = 0.3;
  const Assessment assessment = AssessCalibration(metrics);
  EXPECT_TRUE(HasReason(assessment, "by the model or the detector"));
  EXPECT_TRUE(HasReason(assessment, "take sharper images"));
}

TEST(Assessment, SaysTheWorstFirst) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.better_model = {"opencv", 0.407, 0.413};
  const Assessment pass = AssessCalibration(metrics);
  EXPECT_EQ(pass.word, "pass");
  ASSERT_EQ(pass.reasons.size(), 1u);
  EXPECT_EQ(
      pass.reasons[0],
      "opencv has a lower held-out error: median 0.4070 px, compared with "
      "0.4130 px; calibrate with --model opencv");
  metrics.images_used = 5;
  metrics.tilt_rad = 0.02;
  const Assessment assessment = AssessCalibration(metrics);
  EXPECT_EQ(assessment.word, "fail");
  ASSERT_EQ(assessment.reasons.size(), 3u);
  EXPECT_EQ(assessment.reasons[0].find("the focal length is not observable"),
            0u);
  EXPECT_EQ(assessment.reasons[1].find("only 5 images"), 0u);
  EXPECT_EQ(assessment.reasons[2], pass.reasons[0]);
  EXPECT_EQ(assessment.failure, assessment.reasons[0]);
}

TEST(Assessment, AsksForMoreViewsWhereFewShowAPlace) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.unique_coverage_images = {"a.png", "b.png"};
  metrics.unique_coverage_regions = {"left", "top right"};
  const Assessment assessment = AssessCalibration(metrics);
  EXPECT_EQ(assessment.word, "warn");
  EXPECT_TRUE(HasReason(assessment,
                        "the left, top right of the image is covered by 2 "
                        "images (a.png, ...) only"));
  EXPECT_FALSE(HasReason(assessment, "are inconsistent"));
}

// The error of a model whose boards bend is another figure than that of
// another model whose boards are rigid.
TEST(Assessment, ComparesModelsByFiguresOfOneKind) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.per_view_deformation = true;
  metrics.held_out->median_px = 0.0332;
  metrics.better_model = {"opencv", 0.0383, 0.0412};
  EXPECT_TRUE(HasReason(AssessCalibration(metrics),
                        "median 0.0383 px, rigid target, compared with "
                        "0.0412 px"));
}

TEST(Assessment, WarnsOfImagesHeldOutWhoseViewsWereCalibratedWith) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.held_out_duplicates = {"a.png", "b.png"};
  const Assessment assessment = AssessCalibration(metrics);
  EXPECT_EQ(assessment.word, "warn");
  EXPECT_TRUE(HasReason(assessment,
                        "near-duplicates of training images: 2 images (a.png, "
                        "...); "));
}

TEST(Assessment, SaysNothingOfHundredthsOfAPixel) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.training = {0.002, 0.003, 0.02, 3000};
  metrics.held_out = {0.004, 0.005, 0.03, 3000};
  metrics.neighbor_correlation = 0.6;
  metrics.median_stddev_px = 0.004;
  metrics.valid_share = 0.1;
  metrics.valid_limit_px = 0.0015;
  metrics.extrapolated = {0, 0, ""};
  const Assessment assessment = AssessCalibration(metrics);
  EXPECT_EQ(assessment.word, "pass");
  EXPECT_TRUE(assessment.reasons.empty());
}

TEST(Assessment, SaysWhereAndHowMuchExtrapolationMatters) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.extrapolated = {0.12, 0.72, "corners"};
  const Assessment assessment = AssessCalibration(metrics);
  EXPECT_EQ(assessment.word, "warn");
  ASSERT_EQ(assessment.reasons.size(), 1u);
  EXPECT_EQ(assessment.reasons[0],
            "the corners of the image are extrapolated: expect errors up to "
            "0.72 px there (12 % of the image); move the target into that "
            "part, or use the valid region only");
  metrics.extrapolated->image_regions = "left edge";
  EXPECT_TRUE(HasReason(AssessCalibration(metrics),
                        "the left edge of the image is extrapolated"));
  // Errors below the limit of the valid region do not matter.
  metrics.extrapolated->p95_px = 0.29;
  EXPECT_EQ(AssessCalibration(metrics).word, "pass");
  // Nor do slivers.
  metrics.extrapolated = {0.04, 0.72, "corners"};
  const Assessment sliver = AssessCalibration(metrics);
  EXPECT_EQ(sliver.word, "pass");
  EXPECT_TRUE(HasReason(sliver, "expect errors up to 0.72 px there"));
}

TEST(Assessment, AsksForMoreViewsWhereLittleIsValid) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.median_stddev_px = 0.4;
  metrics.valid_share = 0.45;
  const Assessment assessment = AssessCalibration(metrics);
  EXPECT_EQ(assessment.word, "warn");
  EXPECT_TRUE(HasReason(assessment,
                        "only 45 % of the image is supported by features and "
                        "has a predicted uncertainty below 0.3 px"));
  metrics.valid_share = 0.55;
  EXPECT_EQ(AssessCalibration(metrics).word, "pass");
}

TEST(Assessment, SmallSystematicErrorsAreNotes) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.neighbor_correlation = 0.4;
  const Assessment small = AssessCalibration(metrics);
  EXPECT_EQ(small.word, "pass");
  EXPECT_TRUE(HasReason(small, "systematic errors of about 0.082 px"));
  metrics.held_out->rms_px = 0.3;
  EXPECT_EQ(AssessCalibration(metrics).word, "warn");
}

TEST(Assessment, NamesImagesThatAreMisread) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.num_misread_images = 1;
  metrics.most_misread = {"a.png", 10, 54};
  const Assessment assessment = AssessCalibration(metrics);
  EXPECT_EQ(assessment.word, "warn");
  EXPECT_TRUE(HasReason(assessment,
                        "many features of an image were rejected as outliers "
                        "(a.png: 10 of 54)"));
}

TEST(Assessment, ErrorsOfArithmeticAreNoMatter) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.training = {0, 1e-9, 1e-8, 3000};
  metrics.held_out = {1e-7, 1e-7, 1e-6, 3000};
  metrics.neighbor_correlation = 0.98;
  EXPECT_EQ(AssessCalibration(metrics).word, "pass");
}

TEST(Assessment, ComparesWithATrainingErrorOfZero) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.training.median_px = 0;
  EXPECT_TRUE(HasReason(AssessCalibration(metrics),
                        "the held-out error is 0.11 px, the training error 0 "
                        "px"));
}

TEST(Assessment, FailsViewsThatAreAllTheSame) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.different_views = 1;
  EXPECT_EQ(AssessCalibration(metrics).word, "fail");
}

TEST(Assessment, SaysHowManyImagesShowDifferentViews) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.images_used = metrics.images_kept = 13;
  metrics.num_duplicate_images = 494;
  metrics.images_rejected = 20;
  const Assessment assessment = AssessCalibration(metrics);
  EXPECT_EQ(assessment.word, "pass");
  ASSERT_EQ(assessment.reasons.size(), 1u);
  EXPECT_EQ(
      assessment.reasons[0],
      "507 images show 13 different views; near-duplicates are counted once");
}

TEST(Assessment, CountsViewsWhereImagesAreAlike) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.images_used = metrics.images_kept = 9;
  metrics.num_duplicate_images = 30;
  EXPECT_TRUE(HasReason(AssessCalibration(metrics),
                        "only 9 different views, too few to assess the "
                        "camera; at least 10 are required"));
  metrics.different_views = 2;
  EXPECT_TRUE(HasReason(AssessCalibration(metrics),
                        "39 images show only 2 different views"));
}

TEST(Assessment, WarnsOfEachWeakness) {
  const auto expect_warning = [](const CalibrationMetrics& metrics) {
    const Assessment assessment = AssessCalibration(metrics);
    EXPECT_EQ(assessment.word, "warn");
    EXPECT_EQ(assessment.reasons.size(), 1u);
  };
  CalibrationMetrics metrics = GoodFigures();
  metrics.images_used = 5;
  expect_warning(metrics);
  metrics = GoodFigures();
  metrics.features_area = {200, 200, 400, 300};
  expect_warning(metrics);
  metrics = GoodFigures();
  metrics.images_rejected = 40;
  expect_warning(metrics);
  metrics = GoodFigures();
  metrics.held_out.reset();
  expect_warning(metrics);
  metrics = GoodFigures();
  metrics.training.median_px = metrics.held_out->median_px = 0.5;
  expect_warning(metrics);
  metrics = GoodFigures();
  metrics.held_out->median_px = 0.28;
  expect_warning(metrics);
  metrics = GoodFigures();
  metrics.neighbor_correlation = 0.4;
  metrics.held_out->rms_px = 0.3;
  expect_warning(metrics);
  metrics = GoodFigures();
  metrics.valid_share = 0.2;
  metrics.median_stddev_px = 0.4;
  expect_warning(metrics);
  metrics = GoodFigures();
  metrics.extrapolated = {0.2, 2, "corners"};
  expect_warning(metrics);
  metrics = GoodFigures();
  metrics.outlier_images = {"other.png"};
  expect_warning(metrics);
  metrics = GoodFigures();
  metrics.mirrored_images = {"mirrored.png"};
  expect_warning(metrics);
  metrics = GoodFigures();
  metrics.median_stddev_px.reset();
  expect_warning(metrics);
}

TEST(Assessment, FeaturesThatErrALittleAlikeAreNoMatter) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.neighbor_correlation = 0.15;
  EXPECT_EQ(AssessCalibration(metrics).word, "pass");
}

TEST(Assessment, WarningsDoNotSoftenAFailure) {
  CalibrationMetrics metrics = GoodFigures();
  metrics.converged = false;
  metrics.images_used = 5;
  EXPECT_EQ(AssessCalibration(metrics).word, "fail");
}

}  // namespace
}  // namespace raygrid
