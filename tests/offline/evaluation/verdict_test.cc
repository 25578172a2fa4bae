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
  figures.trusted_part = 0.9;
  figures.trusted_px = 0.05;
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
  EXPECT_TRUE(HasReason(verdict, "hold the board into the corners"));
}

TEST(Verdict, TellsAStrangerAmongAFleet) {
  CalibrationFigures figures = GoodFigures();
  figures.fleet_distance = FleetDistance{1.2, 0.3};
  EXPECT_EQ(JudgeCalibration(figures).word, "pass");
  figures.fleet_distance = FleetDistance{4.1, 0.3};
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "warn");
  EXPECT_TRUE(HasReason(verdict, "4.1 px from the fleet's middle"));
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
  figures.trusted_part = 0;
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "fail");
  ASSERT_EQ(verdict.reasons.size(), 1u);
  EXPECT_NE(verdict.reasons[0].find("tilt the board"), std::string::npos);
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
  figures.trusted_part.reset();
  figures.trusted_px.reset();
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "fail");
  ASSERT_EQ(verdict.reasons.size(), 1u);
  EXPECT_EQ(verdict.reasons[0],
            "interrupted before it was done; go on with --resume");
}

TEST(Verdict, FailsTrustedPixelsThatFoldOver) {
  CalibrationFigures figures = GoodFigures();
  figures.fold_over = {0.008, 0.001};
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "fail");
  EXPECT_TRUE(HasReason(verdict, "0.1 % of the calibrated area folds over"));
}

TEST(Verdict, RemarksOnOtherPixelsThatFoldOver) {
  CalibrationFigures figures = GoodFigures();
  figures.fold_over = {0.008, 0};
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "pass");
  EXPECT_TRUE(HasReason(verdict, "0.8 % of the calibrated area folds over"));
}

TEST(Verdict, NamesImagesFromBehindHoweverFew) {
  CalibrationFigures figures = GoodFigures();
  figures.images_from_behind = {"a.png", "b.png"};
  EXPECT_TRUE(
      HasReason(JudgeCalibration(figures),
                "2 of 30 times the board is seen from behind (a.png, ...)"));
}

TEST(Verdict, SuspectsThePatternWhereMostImagesHaveTooFewFeatures) {
  CalibrationFigures figures = GoodFigures();
  figures.images_rejected = 40;
  figures.images_with_too_few_features = 36;
  EXPECT_TRUE(HasReason(JudgeCalibration(figures),
                        "36 of 70 images have too few features; check the "
                        "pattern's columns and rows"));
  figures.images_with_too_few_features = 35;
  EXPECT_TRUE(HasReason(JudgeCalibration(figures), "40 images were rejected"));
}

TEST(Verdict, WarnsOfImagesOfTwoCameras) {
  CalibrationFigures figures = GoodFigures();
  figures.neighbor_correlation = 0.6;
  figures.two_cameras = {{"left1.png", "left2.png"}, {"right1.png"}};
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "warn");
  ASSERT_EQ(verdict.reasons.size(), 1u);
  EXPECT_TRUE(HasReason(verdict,
                        "these images look like two cameras: 2 images "
                        "(left1.png, ...) and 1 images (right1.png)"));
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
  figures.limit = {"row time", "errors grow from row to row", "keep still"};
  const Verdict verdict = JudgeCalibration(figures);
  ASSERT_EQ(verdict.reasons.size(), 2u);
  EXPECT_EQ(verdict.reasons[0],
            "neighbouring features err alike (correlation 0.60): about 0.10 px "
            "are not noise; errors grow from row to row; keep still");
  EXPECT_EQ(verdict.reasons[1],
            "the held-out error is 0.50 px; the same would lower it");
  figures.neighbor_correlation = 0;
  const Verdict alone = JudgeCalibration(figures);
  ASSERT_EQ(alone.reasons.size(), 1u);
  EXPECT_EQ(alone.reasons[0],
            "the held-out error is 0.50 px; errors grow from row to row; keep "
            "still");
}

TEST(Verdict, NoiseThatIsToldBlamesNoBoard) {
  CalibrationFigures figures = GoodFigures();
  figures.held_out->median_px = figures.training.median_px = 0.5;
  EXPECT_TRUE(HasReason(JudgeCalibration(figures), "flatter board"));
  figures.limit = {"noise", "feature noise", "take sharper images"};
  EXPECT_FALSE(HasReason(JudgeCalibration(figures), "flatter board"));
  EXPECT_TRUE(HasReason(JudgeCalibration(figures), "take sharper images"));
  // Neighbours are another matter.
  figures.neighbor_correlation = 0.3;
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_TRUE(HasReason(verdict, "the model's error"));
  EXPECT_TRUE(HasReason(verdict, "take sharper images"));
}

TEST(Verdict, SaysFirstWhichModelPredictsBetter) {
  CalibrationFigures figures = GoodFigures();
  figures.images_used = 5;
  figures.held_out->median_px = 0.413;
  figures.better_model = {"opencv", 0.407, 0.413};
  const Verdict verdict = JudgeCalibration(figures);
  ASSERT_FALSE(verdict.reasons.empty());
  EXPECT_EQ(verdict.reasons[0],
            "opencv predicts held-out images better, with 0.4070 px (median) "
            "against 0.4130 px: raygrid calibrate ... --model opencv");
  CalibrationFigures good = GoodFigures();
  good.better_model = {"opencv", 0.1, 0.11};
  EXPECT_EQ(JudgeCalibration(good).word, "pass");
}

TEST(Verdict, AsksForMoreViewsWhereFewShowAPlace) {
  CalibrationFigures figures = GoodFigures();
  figures.images_alone = {"a.png", "b.png"};
  figures.places_alone = {"left", "top right"};
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "warn");
  EXPECT_TRUE(HasReason(verdict,
                        "only 2 images (a.png, ...) show the left, top right "
                        "of the image"));
  EXPECT_FALSE(HasReason(verdict, "do not fit"));
}

// The error of a model whose boards bend is another figure than that of
// another model whose boards are rigid.
TEST(Verdict, ComparesModelsByFiguresOfOneKind) {
  CalibrationFigures figures = GoodFigures();
  figures.boards_bend = true;
  figures.held_out->median_px = 0.0332;
  figures.better_model = {"opencv", 0.0383, 0.0412};
  EXPECT_TRUE(HasReason(JudgeCalibration(figures),
                        "with 0.0383 px (median, rigid boards) against "
                        "0.0412 px"));
}

TEST(Verdict, WarnsOfImagesHeldOutWhoseViewsWereCalibratedWith) {
  CalibrationFigures figures = GoodFigures();
  figures.held_out_copies = {"a.png", "b.png"};
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "warn");
  EXPECT_TRUE(HasReason(verdict,
                        "(2: a.png, ...), so the held-out error is "
                        "too small"));
}

TEST(Verdict, SaysNothingOfHundredthsOfAPixel) {
  CalibrationFigures figures = GoodFigures();
  figures.training = {0.002, 0.003, 0.02, 3000};
  figures.held_out = {0.004, 0.005, 0.03, 3000};
  figures.neighbor_correlation = 0.6;
  figures.median_deviation_px = 0.004;
  figures.trusted_part = 0.1;
  figures.trusted_px = 0.0015;
  const Verdict verdict = JudgeCalibration(figures);
  EXPECT_EQ(verdict.word, "pass");
  EXPECT_TRUE(verdict.reasons.empty());
}

// calibrate and the report print the same figure.
TEST(Verdict, CountsWhatIsTrustedByTheImage) {
  CalibrationFigures figures = GoodFigures();
  figures.features_area = {0, 0, 400, 480};
  figures.median_deviation_px = 0.08;
  figures.trusted_part = 0.25;
  EXPECT_TRUE(HasReason(JudgeCalibration(figures),
                        "only 25 % of the image is trusted, known to 0.0500 "
                        "px"));
  figures.trusted_part = 0.35;  // more than half of the calibrated area
  EXPECT_EQ(JudgeCalibration(figures).word, "pass");
}

TEST(Verdict, SaysNothingOfATenthOfTheNoise) {
  CalibrationFigures figures = GoodFigures();
  figures.training = {0.6, 0.8, 3, 3000};
  figures.held_out = {0.6, 0.8, 3, 3000};
  figures.median_deviation_px = 0.07;
  figures.trusted_part = 0.1;
  EXPECT_FALSE(HasReason(JudgeCalibration(figures), "trusted"));
  figures.median_deviation_px = 0.09;
  EXPECT_TRUE(HasReason(JudgeCalibration(figures), "10 % of the image"));
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
  EXPECT_TRUE(
      HasReason(JudgeCalibration(figures),
                "the held-out error is 0.11 px, the training error 0 px"));
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
  EXPECT_EQ(verdict.reasons[0],
            "507 images show 13 different views, each of which counts once");
}

TEST(Verdict, CountsViewsWhereImagesAreAlike) {
  CalibrationFigures figures = GoodFigures();
  figures.images_used = figures.images_kept = 9;
  figures.images_alike = 30;
  EXPECT_TRUE(HasReason(JudgeCalibration(figures),
                        "only 9 different views; take 10 or more"));
  figures.different_views = 2;
  EXPECT_TRUE(HasReason(JudgeCalibration(figures),
                        "only 2 different ways in 39 images"));
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
  figures.images_rejected = 10;
  expect_warning(figures);
  figures = GoodFigures();
  figures.held_out.reset();
  expect_warning(figures);
  figures = GoodFigures();
  figures.training.median_px = figures.held_out->median_px = 0.5;
  expect_warning(figures);
  figures = GoodFigures();
  figures.held_out->median_px = 0.2;
  expect_warning(figures);
  figures = GoodFigures();
  figures.neighbor_correlation = 0.4;
  expect_warning(figures);
  figures = GoodFigures();
  figures.trusted_part = 0.2;
  figures.median_deviation_px = 0.08;
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
