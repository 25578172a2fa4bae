#include "evaluation/verdict.h"

#include "support.h"

namespace raygrid {
namespace {

CalibrationFigures GoodFigures() {
  CalibrationFigures figures;
  figures.converged = true;
  figures.image_size = {640, 480};
  figures.area = {10, 10, 630, 470};
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

TEST(Verdict, PassesGoodFigures) {
  const Verdict verdict = JudgeCalibration(GoodFigures());
  EXPECT_EQ(verdict.word, "pass");
  EXPECT_TRUE(verdict.reasons.empty());
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

TEST(Verdict, FailsViewsThatAreAllTheSame) {
  CalibrationFigures figures = GoodFigures();
  figures.different_views = 1;
  EXPECT_EQ(JudgeCalibration(figures).word, "fail");
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
  figures.area = {200, 200, 400, 300};
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
  expect_warning(figures);
  figures = GoodFigures();
  figures.images_apart = {"other.png"};
  expect_warning(figures);
  figures = GoodFigures();
  figures.boards_seen_from_behind = 30;
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
