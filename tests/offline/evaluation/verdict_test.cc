#include "evaluation/verdict.h"

#include <algorithm>

#include "support.h"

namespace raygrid {
namespace {

CalibrationFigures GoodFigures() {
  CalibrationFigures figures;
  figures.tried.model = "central-generic";
  figures.converged = true;
  figures.image_size = {640, 480};
  figures.features_area = {10, 10, 630, 470};
  figures.images_used = 30;
  figures.training = {0.10, 0.12, 0.8, 3000};
  figures.held_out = {0.11, 0.13, 0.9, 3000};
  figures.boards_seen = figures.different_views = 30;
  figures.tilt_rad = 0.8;
  figures.median_deviation_px = 0.02;
  figures.valid_share = 0.95;
  figures.valid_limit_px = 0.3;
  figures.extrapolated = {0.02, 0.1, "corners"};
  return figures;
}

bool HasReason(const Verdict& verdict, const std::string& words) {
  return std::any_of(verdict.reasons.begin(), verdict.reasons.end(),
                     [&](const std::string& reason) {
                       return reason.find(words) != std::string::npos;
                     });
}

TEST(Verdict, PassesGoodFigures) {
  const Verdict verdict = JudgeCalibration(GoodFigures());
  EXPECT_EQ(verdict.word, "pass");
  EXPECT_TRUE(verdict.reasons.empty());
}

// Features of images of half the size lie in a quarter of the image.
TEST(Verdict, DoubtsTheImageSizeOfFeaturesInAQuarter) {
  CalibrationFigures figures = GoodFigures();
  figures.features_area = {5, 5, 317, 238};
  EXPECT_TRUE(HasReason(JudgeCalibration(figures), "check --image-size"));
  figures.features_area = {5, 5, 317, 400};
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_FALSE(HasReason(verdict, "check --image-size"));
  EXPECT_TRUE(HasReason(verdict, "move the target into the corners"));
}

TEST(Verdict, TellsAStrangerAmongAFleet) {
  CalibrationFigures figures = GoodFigures();
  figures.fleet_distance = FleetDistance{1.2, 0.3};
  EXPECT_EQ(JudgeCalibration(figures).word, "pass");
  figures.fleet_distance = FleetDistance{4.1, 0.3};
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "warn");
  EXPECT_TRUE(HasReason(verdict, "4.1 px RMS from the population mean"));
}

TEST(Verdict, FailsWhatDidNotConverge) {
  CalibrationFigures figures = GoodFigures();
  figures.converged = false;
  EXPECT_EQ(JudgeCalibration(figures).word, "fail");
}

TEST(Verdict, FailsLargeHeldOutErrors) {
  CalibrationFigures figures = GoodFigures();
  figures.training.median_px = figures.held_out->median_px = 2.5;
  EXPECT_EQ(JudgeCalibration(figures).word, "fail");
}

TEST(Verdict, FailsViewsThatLeaveTheCameraOpen) {
  CalibrationFigures figures = GoodFigures();
  figures.median_deviation_px = 15;
  figures.valid_share = 0;
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "fail");
  ASSERT_EQ(verdict.reasons.size(), 1u);
  EXPECT_EQ(verdict.reasons[0].find("the views do not determine the camera: "
                                    "expect errors of 15 px"),
            0u);
}

TEST(Verdict, FailsBoardsThatAreAllParallel) {
  CalibrationFigures figures = GoodFigures();
  figures.tilt_rad = 0.02;
  EXPECT_EQ(JudgeCalibration(figures).word, "fail");
}

TEST(Verdict, PointsInSpaceNeedNoTilt) {
  CalibrationFigures figures = GoodFigures();
  figures.tilt_rad.reset();
  EXPECT_EQ(JudgeCalibration(figures).word, "pass");
}

TEST(Verdict, AnInterruptedCalibrationSaysOnlyThat) {
  CalibrationFigures figures = GoodFigures();
  figures.converged = false;
  figures.interrupted = true;
  figures.neighbor_correlation = 0.9;
  figures.held_out.reset();
  figures.median_deviation_px.reset();
  figures.valid_share.reset();
  figures.valid_limit_px.reset();
  figures.extrapolated.reset();
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "fail");
  ASSERT_EQ(verdict.reasons.size(), 1u);
  EXPECT_EQ(verdict.reasons[0],
            "interrupted before completion; continue with --resume");
}

TEST(Verdict, FailsValidPixelsThatFoldOver) {
  CalibrationFigures figures = GoodFigures();
  figures.fold_over = {0.008, 0.001};
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "fail");
  EXPECT_TRUE(
      HasReason(verdict, "is not injective within the valid region (0.1 %"));
}

TEST(Verdict, RemarksOnOtherPixelsThatFoldOver) {
  CalibrationFigures figures = GoodFigures();
  figures.fold_over = {0.008, 0};
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "pass");
  EXPECT_TRUE(
      HasReason(verdict, "is not injective outside the valid region (0.8 %"));
}

TEST(Verdict, NamesImagesFromBehindHoweverFew) {
  CalibrationFigures figures = GoodFigures();
  figures.images_from_behind = {"a.png", "b.png"};
  EXPECT_TRUE(HasReason(
      JudgeCalibration(figures),
      "the target is seen from behind in 2 of 30 views (a.png, ...)"));
}

TEST(Verdict, SuspectsThePatternWhereMostImagesHaveTooFewFeatures) {
  CalibrationFigures figures = GoodFigures();
  figures.images_rejected = 40;
  figures.images_with_too_few_features = 36;
  EXPECT_TRUE(HasReason(JudgeCalibration(figures),
                        "36 of 70 images have too few features; check the "
                        "pattern's columns and rows"));
  figures.images_with_too_few_features = 35;
  EXPECT_TRUE(
      HasReason(JudgeCalibration(figures), "40 of 70 images were rejected"));
}

TEST(Verdict, WarnsOfImagesOfTwoCameras) {
  CalibrationFigures figures = GoodFigures();
  figures.neighbor_correlation = 0.6;
  figures.two_cameras = {{"left1.png", "left2.png"}, {"right1.png"}};
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "warn");
  ASSERT_EQ(verdict.reasons.size(), 1u);
  EXPECT_TRUE(HasReason(verdict,
                        "these images appear to come from two cameras: 2 "
                        "images (left1.png, ...) and 1 image (right1.png)"));
}

TEST(Verdict, SuspectsSeveralCamerasWhereNearlyAllErrorIsShared) {
  CalibrationFigures figures = GoodFigures();
  figures.neighbor_correlation = 0.95;
  EXPECT_TRUE(
      HasReason(JudgeCalibration(figures), "images of several cameras"));
  figures.neighbor_correlation = 0.6;
  EXPECT_FALSE(
      HasReason(JudgeCalibration(figures), "images of several cameras"));
}

TEST(Verdict, AdvisesNoModelThatIsInUse) {
  CalibrationFigures figures = GoodFigures();
  figures.neighbor_correlation = 0.6;
  EXPECT_TRUE(HasReason(JudgeCalibration(figures), "noncentral-generic"));
  figures.tried.model = "noncentral-generic";
  EXPECT_FALSE(HasReason(JudgeCalibration(figures), "noncentral-generic"));
  EXPECT_TRUE(HasReason(JudgeCalibration(figures), "--knot-spacing-px auto"));
  figures.tried.model = "opencv";
  EXPECT_TRUE(HasReason(JudgeCalibration(figures), "central-generic"));
  EXPECT_FALSE(
      HasReason(JudgeCalibration(figures), "smaller --knot-spacing-px"));
}

TEST(Verdict, AdvisesNothingThatWasTried) {
  CalibrationFigures figures = GoodFigures();
  figures.neighbor_correlation = 0.6;
  figures.tried.cells_chosen = true;
  figures.tried.cell_px = 26.8;
  EXPECT_TRUE(HasReason(JudgeCalibration(figures), "--knot-spacing-px 13"));
  figures.tried.tried_finer = true;
  EXPECT_FALSE(HasReason(JudgeCalibration(figures), "cells"));
  EXPECT_TRUE(HasReason(JudgeCalibration(figures), "noncentral-generic"));
  figures.tried.noncentral_tried = true;
  EXPECT_FALSE(HasReason(JudgeCalibration(figures), "noncentral-generic"));
  EXPECT_TRUE(HasReason(JudgeCalibration(figures), "are no better"));
}

TEST(Verdict, SendsNobodyFromModelToModelAndBack) {
  CalibrationFigures figures = GoodFigures();
  figures.tried.model = "opencv";
  figures.neighbor_correlation = 0.6;
  figures.tried.generic_tried = true;
  EXPECT_FALSE(HasReason(JudgeCalibration(figures), "--model central-generic"));
  figures.better_model = {"central-generic", 0.1, 0.11};
  figures.tried.better_model = "central-generic";
  EXPECT_TRUE(HasReason(JudgeCalibration(figures), "--model central-generic"));
}

// Whichever other advice there would be.
TEST(Verdict, AdvisesWhatTheCauseOfResidualsAsksFor) {
  CalibrationFigures figures = GoodFigures();
  figures.neighbor_correlation = 0.6;
  figures.held_out->median_px = figures.training.median_px = 0.5;
  figures.limit = {"rolling shutter", "errors grow from row to row",
                   "keep still"};
  const Verdict verdict = JudgeCalibration(figures);
  ASSERT_EQ(verdict.reasons.size(), 2u);
  EXPECT_EQ(verdict.reasons[0],
            "the median held-out error is 0.5 px; the remedy for systematic "
            "errors reduces it, too");
  EXPECT_EQ(verdict.reasons[1],
            "systematic errors of about 0.1 px (neighbouring residuals are "
            "correlated: 0.60): errors grow from row to row; keep still");
  figures.neighbor_correlation = 0;
  const Verdict alone = JudgeCalibration(figures);
  ASSERT_EQ(alone.reasons.size(), 1u);
  EXPECT_EQ(alone.reasons[0],
            "the median held-out error is 0.5 px: errors grow from row to row; "
            "keep still");
}

TEST(Verdict, NoiseThatIsToldBlamesNoBoard) {
  CalibrationFigures figures = GoodFigures();
  figures.held_out->median_px = figures.training.median_px = 0.5;
  EXPECT_TRUE(HasReason(JudgeCalibration(figures), "flatter target"));
  figures.limit = {"noise", "feature noise", "take sharper images"};
  EXPECT_FALSE(HasReason(JudgeCalibration(figures), "flatter target"));
  EXPECT_TRUE(HasReason(JudgeCalibration(figures), "take sharper images"));
  // Neighbours are another matter.
  figures.neighbor_correlation = 0.3;
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_TRUE(HasReason(verdict, "by the model or the detector"));
  EXPECT_TRUE(HasReason(verdict, "take sharper images"));
}

TEST(Verdict, SaysTheWorstFirst) {
  CalibrationFigures figures = GoodFigures();
  figures.better_model = {"opencv", 0.407, 0.413};
  const Verdict pass = JudgeCalibration(figures);
  EXPECT_EQ(pass.word, "pass");
  ASSERT_EQ(pass.reasons.size(), 1u);
  EXPECT_EQ(
      pass.reasons[0],
      "opencv has a lower held-out error: median 0.4070 px, compared with "
      "0.4130 px; calibrate with --model opencv");
  figures.images_used = 5;
  figures.tilt_rad = 0.02;
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "fail");
  ASSERT_EQ(verdict.reasons.size(), 3u);
  EXPECT_EQ(verdict.reasons[0].find("the focal length is not observable"), 0u);
  EXPECT_EQ(verdict.reasons[1].find("only 5 images"), 0u);
  EXPECT_EQ(verdict.reasons[2], pass.reasons[0]);
  EXPECT_EQ(verdict.failure, verdict.reasons[0]);
}

TEST(Verdict, AsksForMoreViewsWhereFewShowAPlace) {
  CalibrationFigures figures = GoodFigures();
  figures.images_alone = {"a.png", "b.png"};
  figures.places_alone = {"left", "top right"};
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "warn");
  EXPECT_TRUE(HasReason(verdict,
                        "the left, top right of the image is covered by 2 "
                        "images (a.png, ...) only"));
  EXPECT_FALSE(HasReason(verdict, "are inconsistent"));
}

// The error of a model whose boards bend is another figure than that of
// another model whose boards are rigid.
TEST(Verdict, ComparesModelsByFiguresOfOneKind) {
  CalibrationFigures figures = GoodFigures();
  figures.boards_bend = true;
  figures.held_out->median_px = 0.0332;
  figures.better_model = {"opencv", 0.0383, 0.0412};
  EXPECT_TRUE(HasReason(JudgeCalibration(figures),
                        "median 0.0383 px, rigid target, compared with "
                        "0.0412 px"));
}

TEST(Verdict, WarnsOfImagesHeldOutWhoseViewsWereCalibratedWith) {
  CalibrationFigures figures = GoodFigures();
  figures.held_out_copies = {"a.png", "b.png"};
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "warn");
  EXPECT_TRUE(HasReason(verdict,
                        "the held-out error is too optimistic: 2 images "
                        "(a.png, ...)"));
}

TEST(Verdict, SaysNothingOfHundredthsOfAPixel) {
  CalibrationFigures figures = GoodFigures();
  figures.training = {0.002, 0.003, 0.02, 3000};
  figures.held_out = {0.004, 0.005, 0.03, 3000};
  figures.neighbor_correlation = 0.6;
  figures.median_deviation_px = 0.004;
  figures.valid_share = 0.1;
  figures.valid_limit_px = 0.0015;
  figures.extrapolated = {0, 0, ""};
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "pass");
  EXPECT_TRUE(verdict.reasons.empty());
}

TEST(Verdict, SaysWhereAndHowMuchExtrapolationMatters) {
  CalibrationFigures figures = GoodFigures();
  figures.extrapolated = {0.12, 0.72, "corners"};
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "warn");
  ASSERT_EQ(verdict.reasons.size(), 1u);
  EXPECT_EQ(verdict.reasons[0],
            "the corners of the image are extrapolated: expect errors up to "
            "0.72 px there (12 % of the image); move the target into that "
            "part, or use the valid region only");
  figures.extrapolated->where = "left edge";
  EXPECT_TRUE(HasReason(JudgeCalibration(figures),
                        "the left edge of the image is extrapolated"));
  // Errors below the limit of the valid region do not matter.
  figures.extrapolated->p95_px = 0.29;
  EXPECT_EQ(JudgeCalibration(figures).word, "pass");
  // Nor do slivers.
  figures.extrapolated = {0.04, 0.72, "corners"};
  const Verdict sliver = JudgeCalibration(figures);
  EXPECT_EQ(sliver.word, "pass");
  EXPECT_TRUE(HasReason(sliver, "expect errors up to 0.72 px there"));
}

TEST(Verdict, AsksForMoreViewsWhereLittleIsValid) {
  CalibrationFigures figures = GoodFigures();
  figures.median_deviation_px = 0.4;
  figures.valid_share = 0.45;
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "warn");
  EXPECT_TRUE(HasReason(verdict,
                        "only 45 % of the image is supported by features and "
                        "has a predicted uncertainty below 0.3 px"));
  figures.valid_share = 0.55;
  EXPECT_EQ(JudgeCalibration(figures).word, "pass");
}

TEST(Verdict, SmallSystematicErrorsAreNotes) {
  CalibrationFigures figures = GoodFigures();
  figures.neighbor_correlation = 0.4;
  const Verdict small = JudgeCalibration(figures);
  EXPECT_EQ(small.word, "pass");
  EXPECT_TRUE(HasReason(small, "systematic errors of about 0.082 px"));
  figures.held_out->rms_px = 0.3;
  EXPECT_EQ(JudgeCalibration(figures).word, "warn");
}

TEST(Verdict, NamesImagesThatAreMisread) {
  CalibrationFigures figures = GoodFigures();
  figures.num_misread_images = 1;
  figures.most_misread = {"a.png", 10, 54};
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "warn");
  EXPECT_TRUE(HasReason(verdict,
                        "many features of an image were rejected as outliers "
                        "(a.png: 10 of 54)"));
}

TEST(Verdict, ErrorsOfArithmeticAreNoMatter) {
  CalibrationFigures figures = GoodFigures();
  figures.training = {0, 1e-9, 1e-8, 3000};
  figures.held_out = {1e-7, 1e-7, 1e-6, 3000};
  figures.neighbor_correlation = 0.98;
  EXPECT_EQ(JudgeCalibration(figures).word, "pass");
}

TEST(Verdict, ComparesWithATrainingErrorOfZero) {
  CalibrationFigures figures = GoodFigures();
  figures.training.median_px = 0;
  EXPECT_TRUE(HasReason(JudgeCalibration(figures),
                        "the held-out error is 0.11 px, the training error 0 "
                        "px"));
}

TEST(Verdict, FailsViewsThatAreAllTheSame) {
  CalibrationFigures figures = GoodFigures();
  figures.different_views = 1;
  EXPECT_EQ(JudgeCalibration(figures).word, "fail");
}

TEST(Verdict, SaysHowManyImagesShowDifferentViews) {
  CalibrationFigures figures = GoodFigures();
  figures.images_used = figures.images_kept = 13;
  figures.images_alike = 494;
  figures.images_rejected = 20;
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "pass");
  ASSERT_EQ(verdict.reasons.size(), 1u);
  EXPECT_EQ(
      verdict.reasons[0],
      "507 images show 13 different views; near-duplicates are counted once");
}

TEST(Verdict, CountsViewsWhereImagesAreAlike) {
  CalibrationFigures figures = GoodFigures();
  figures.images_used = figures.images_kept = 9;
  figures.images_alike = 30;
  EXPECT_TRUE(HasReason(JudgeCalibration(figures),
                        "only 9 different views, too few to assess the "
                        "camera; at least 10 are required"));
  figures.different_views = 2;
  EXPECT_TRUE(HasReason(JudgeCalibration(figures),
                        "39 images show only 2 different views"));
}

TEST(Verdict, WarnsOfEachWeakness) {
  const auto expect_warning = [](const CalibrationFigures& figures) {
    const Verdict verdict = JudgeCalibration(figures);
    EXPECT_EQ(verdict.word, "warn");
    EXPECT_EQ(verdict.reasons.size(), 1u);
  };
  CalibrationFigures figures = GoodFigures();
  figures.images_used = 5;
  expect_warning(figures);
  figures = GoodFigures();
  figures.features_area = {200, 200, 400, 300};
  expect_warning(figures);
  figures = GoodFigures();
  figures.images_rejected = 40;
  expect_warning(figures);
  figures = GoodFigures();
  figures.held_out.reset();
  expect_warning(figures);
  figures = GoodFigures();
  figures.training.median_px = figures.held_out->median_px = 0.5;
  expect_warning(figures);
  figures = GoodFigures();
  figures.held_out->median_px = 0.28;
  expect_warning(figures);
  figures = GoodFigures();
  figures.neighbor_correlation = 0.4;
  figures.held_out->rms_px = 0.3;
  expect_warning(figures);
  figures = GoodFigures();
  figures.valid_share = 0.2;
  figures.median_deviation_px = 0.4;
  expect_warning(figures);
  figures = GoodFigures();
  figures.extrapolated = {0.2, 2, "corners"};
  expect_warning(figures);
  figures = GoodFigures();
  figures.images_apart = {"other.png"};
  expect_warning(figures);
  figures = GoodFigures();
  figures.images_from_behind = {"mirrored.png"};
  expect_warning(figures);
  figures = GoodFigures();
  figures.median_deviation_px.reset();
  expect_warning(figures);
}

TEST(Verdict, FeaturesThatErrALittleAlikeAreNoMatter) {
  CalibrationFigures figures = GoodFigures();
  figures.neighbor_correlation = 0.15;
  EXPECT_EQ(JudgeCalibration(figures).word, "pass");
}

TEST(Verdict, WarningsDoNotSoftenAFailure) {
  CalibrationFigures figures = GoodFigures();
  figures.converged = false;
  figures.images_used = 5;
  EXPECT_EQ(JudgeCalibration(figures).word, "fail");
}

}  // namespace
}  // namespace raygrid
