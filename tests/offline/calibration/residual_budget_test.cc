#include "evaluation/residual_budget.h"

#include <string>

#include "calibration/budget_input.h"
#include "calibration/calibration.h"
#include "evaluation/budget_verdict.h"
#include "simulation/faulty_observations.h"
#include "simulation/simulated_camera.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

constexpr double kBudgetNoisePx = 0.05;

SimulationOptions BudgetSimulation(uint64_t seed) {
  SimulationOptions options;
  options.num_images = 40;
  options.features_per_image = 120;
  options.noise_px = kBudgetNoisePx;
  options.seed = seed;
  return options;
}

BudgetInput InputWith(SimulatedFault fault, const SimulationOptions& options) {
  const auto camera = SimulatedLens("example", {640, 480});
  const Pattern pattern = ChessboardPattern(17, 11, 0.024);
  return BudgetInputOf(
      *camera, SimulateFaultyObservations(*camera, pattern, options, fault),
      pattern, 2);
}

ResidualBudget BudgetWith(SimulatedFault fault, uint64_t seed) {
  return MeasureResidualBudget(InputWith(fault, BudgetSimulation(seed)));
}

// An error of each axis is taken by a pose: 6 of 240 numbers.
TEST(ResidualBudget, NoiseAloneIsNoise) {
  for (const uint64_t seed : {1, 2, 3, 4, 5}) {
    const ResidualBudget budget = BudgetWith(SimulatedFault::kNone, seed);
    ASSERT_EQ(budget.untold, "");
    EXPECT_NEAR(budget.noise_px.x(), kBudgetNoisePx, 0.05 * kBudgetNoisePx);
    EXPECT_NEAR(budget.noise_px.y(), kBudgetNoisePx, 0.05 * kBudgetNoisePx);
    EXPECT_NEAR(budget.noise, 1, 0.05);
    EXPECT_NEAR(budget.rest, 0, 0.05);
    EXPECT_LT(budget.large, 0.001);
    for (const CauseShare& share : budget.causes) {
      ASSERT_TRUE(share.can_be_told);
      EXPECT_EQ(share.in_turn, 0);
      EXPECT_LE(share.alone, std::max(share.chance_high, 0.002));
      EXPECT_LT(share.chance_high, 0.01);
    }
    EXPECT_EQ(JudgeBudget(budget).limit, "noise");
  }
}

// A pose takes up a scale of a pinhole's image. What is left of it may not be
// the noise that pixels have.
TEST(ResidualBudget, NoiseOfAPinholeIsNoise) {
  for (const uint64_t seed : {1, 2, 3}) {
    SimulationOptions options = BudgetSimulation(seed);
    options.features_per_image = 48;
    const auto camera = SimulatedLens("pinhole", {640, 480});
    const Pattern pattern = ChessboardPattern(8, 6, 0.025);
    const ResidualBudget budget = MeasureResidualBudget(BudgetInputOf(
        *camera, SimulateObservations(*camera, pattern, options).dataset,
        pattern, 2));
    EXPECT_EQ(JudgeBudget(budget).limit, "noise") << seed;
    EXPECT_LT(budget.Of(ErrorCause::kImageAffine).alone, 0.01) << seed;
  }
}

// Faults and causes have the same names.
TEST(ResidualBudget, NamesTheFaultThatIsThere) {
  for (const uint64_t seed : {1, 2, 3}) {
    SimulationOptions options = BudgetSimulation(seed);
    options.num_images = 100;
    for (int f = 1; f < kNumFaults; ++f) {
      const auto fault = static_cast<SimulatedFault>(f);
      const ResidualBudget budget =
          MeasureResidualBudget(InputWith(fault, options));
      EXPECT_EQ(JudgeBudget(budget).limit, NameOf(fault)) << seed;
      double sum = budget.noise + budget.large + budget.rest;
      for (int k = 0; k < kNumErrorCauses; ++k) {
        const CauseShare& share = budget.Of(static_cast<ErrorCause>(k));
        sum += share.in_turn;
        if (k + 1 == f)
          EXPECT_GT(share.in_turn, 0.4) << NameOf(fault);
        else
          EXPECT_LT(share.in_turn, 0.05) << NameOf(fault);
      }
      EXPECT_NEAR(sum, 1, 1e-9);
    }
  }
}

// Fewer images may leave open which cause it is, but they name no other.
TEST(ResidualBudget, NamesNoOtherCauseInFewerImages) {
  for (const uint64_t seed : {1, 2, 3, 4}) {
    for (int f = 3; f < kNumFaults; ++f) {
      const auto fault = static_cast<SimulatedFault>(f);
      const BudgetVerdict verdict = JudgeBudget(BudgetWith(fault, seed));
      EXPECT_TRUE(verdict.limit == NameOf(fault) ||
                  (verdict.limit == "per-view effects" &&
                   verdict.sentence.find(NameOf(fault)) != std::string::npos))
          << seed << " " << NameOf(fault) << ": " << verdict.sentence;
    }
  }
}

TEST(ResidualBudget, NamesBendsOfACalibrationWithRigidBoards) {
  SimulationOptions simulation;
  simulation.num_images = 16;
  simulation.features_per_image = 130;
  simulation.noise_px = 0.02;
  simulation.board_flex_m = 0.0004;
  CalibrationOptions options;
  options.cell_px = 160;
  options.rigid_board = true;
  options.num_threads = 2;
  CalibrationResult result = Calibrate(
      SimulateObservations(ExampleSimulatedCamera(), TestBoard(), simulation)
          .dataset,
      TestBoard(), options);
  ASSERT_TRUE(result.budget.has_value());
  ResidualBudget budget = *result.budget;
  EXPECT_EQ(JudgeBudget(budget).limit, "per-view deformation");
  EXPECT_GT(budget.Of(ErrorCause::kBend).in_turn, 0.4);
  // Only things that were not tried are advised.
  EXPECT_NE(JudgeBudget(budget).advice.find("--rigid-target"),
            std::string::npos);
  budget.facts.bends_tried = true;
  EXPECT_NE(JudgeBudget(budget).advice.find("glass"), std::string::npos);
}

TEST(ResidualBudget, LargeErrorsDoNotHideTheNoise) {
  BudgetInput input = InputWith(SimulatedFault::kNone, BudgetSimulation(1));
  for (size_t i = 50; i < input.features.size(); i += 400)
    input.features[i].error_px += Eigen::Vector2d(2, -1);
  const ResidualBudget budget = MeasureResidualBudget(input);
  EXPECT_GT(budget.large, 0.3);
  EXPECT_NEAR(budget.noise_px.x(), kBudgetNoisePx, 0.1 * kBudgetNoisePx);
  EXPECT_EQ(JudgeBudget(budget).limit, "outliers");
}

TEST(ResidualBudget, FewViewsDoNotTellPlaces) {
  SimulationOptions few = BudgetSimulation(1);
  few.num_images = 7;
  const ResidualBudget budget =
      MeasureResidualBudget(InputWith(SimulatedFault::kRowTime, few));
  EXPECT_FALSE(budget.Of(ErrorCause::kImagePlace).can_be_told);
  EXPECT_EQ(budget.Of(ErrorCause::kBoardPlace).untold,
            "7 views, at least 8 required");
  EXPECT_TRUE(budget.Of(ErrorCause::kRowTime).IsTold());
}

TEST(ResidualBudget, FewFeaturesDoNotTellViews) {
  BudgetInput input = InputWith(SimulatedFault::kBend, BudgetSimulation(1));
  std::vector<BudgetFeature> few;
  std::vector<int> count(40, 0);
  for (const BudgetFeature& feature : input.features)
    if (++count[feature.view] < 24) few.push_back(feature);
  input.features = few;
  const ResidualBudget budget = MeasureResidualBudget(input);
  EXPECT_FALSE(budget.Of(ErrorCause::kBend).can_be_told);
  EXPECT_TRUE(budget.Of(ErrorCause::kImagePlace).can_be_told);
  input.features.resize(150);
  const ResidualBudget nothing = MeasureResidualBudget(input);
  EXPECT_EQ(nothing.untold, "150 features, at least 200 required");
  EXPECT_NE(JudgeBudget(nothing).sentence.find("not observable"),
            std::string::npos);
}

TEST(ResidualBudget, ExactFeaturesHaveNoErrors) {
  BudgetInput input = InputWith(SimulatedFault::kNone, BudgetSimulation(1));
  for (BudgetFeature& feature : input.features) feature.error_px.setZero();
  EXPECT_EQ(MeasureResidualBudget(input).untold, "all residuals are zero");
}

// A budget whose only cause is one.
ResidualBudget BudgetOf(ErrorCause cause, const BudgetFacts& facts) {
  ResidualBudget budget;
  budget.facts = facts;
  CauseShare& share = budget.causes[static_cast<size_t>(cause)];
  share.can_be_told = true;
  share.in_turn = share.alone = 0.5;
  budget.noise = 0.5;
  return budget;
}

TEST(JudgeBudget, AdvisesNothingThatWasDone) {
  const auto advice = [](ErrorCause cause, const BudgetFacts& facts) {
    return JudgeBudget(BudgetOf(cause, facts)).advice;
  };
  const auto has = [](const std::string& text, const char* word) {
    return text.find(word) != std::string::npos;
  };
  BudgetFacts facts;
  facts.model = "opencv";
  EXPECT_TRUE(has(advice(ErrorCause::kImagePlace, facts), "--model central"));
  EXPECT_TRUE(
      has(advice(ErrorCause::kBoardPlace, facts), "--fix-target-geometry"));
  facts.generic_tried = true;
  EXPECT_FALSE(has(advice(ErrorCause::kImagePlace, facts), "--model"));
  facts.model = "central-generic";
  facts.points_free = facts.bends_tried = true;
  facts.cell_px = 80;
  EXPECT_TRUE(
      has(advice(ErrorCause::kImagePlace, facts), "--knot-spacing-px 40"));
  EXPECT_TRUE(has(advice(ErrorCause::kBoardPlace, facts), "print"));
  EXPECT_TRUE(has(advice(ErrorCause::kBend, facts), "glass"));
  facts.tried_finer = true;
  EXPECT_TRUE(has(advice(ErrorCause::kImagePlace, facts), "add images"));
  EXPECT_FALSE(
      has(advice(ErrorCause::kImagePlace, facts), "--knot-spacing-px"));
  facts.better_model = "noncentral-generic";
  EXPECT_TRUE(has(advice(ErrorCause::kImagePlace, facts),
                  "--model noncentral-generic, which has a lower"));
  facts.two_cameras = true;
  EXPECT_TRUE(has(advice(ErrorCause::kImagePlace, facts), "two cameras"));
}

TEST(JudgeBudget, NamesNoCauseThatAnotherExplainsAsWell) {
  ResidualBudget budget = BudgetOf(ErrorCause::kRowTime, {});
  EXPECT_EQ(JudgeBudget(budget).limit, "rolling shutter");
  budget.causes[static_cast<size_t>(ErrorCause::kRowTime)].is_alike = true;
  EXPECT_EQ(JudgeBudget(budget).limit, "rolling shutter");
  budget.column_time_is_alike = true;
  EXPECT_EQ(JudgeBudget(budget).limit, "per-view effects");
  EXPECT_NE(JudgeBudget(budget).sentence.find("candidates: rolling shutter"),
            std::string::npos);
  // The model may be to blame where no cause is.
  budget.facts.model = "opencv";
  EXPECT_NE(
      JudgeBudget(budget).advice.find("first use --model central-generic"),
      std::string::npos);
  budget.facts.generic_tried = true;
  EXPECT_EQ(JudgeBudget(budget).advice.find("--model"), std::string::npos);
  budget.facts.model = "central-generic";
  budget.facts.points_free = false;
  EXPECT_NE(JudgeBudget(budget).advice.find(
                "first calibrate without --fix-target-geometry"),
            std::string::npos);
  budget.facts.points_free = true;
  EXPECT_NE(
      JudgeBudget(budget).advice.find("first use --model noncentral-generic"),
      std::string::npos);
  budget.facts.noncentral_tried = true;
  EXPECT_EQ(JudgeBudget(budget).advice.find("--model"), std::string::npos);
  budget.facts.better_model = "noncentral-generic";
  EXPECT_NE(JudgeBudget(budget).advice.find(
                "--model noncentral-generic, which has a lower"),
            std::string::npos);
}

// A cause that is not told says of errors that neighbours share what the
// verdict does.
TEST(JudgeBudget, AdvisesOfTheRestWhatTheVerdictDoes) {
  ResidualBudget budget;
  budget.noise = 0.3;
  budget.rest = 0.7;
  budget.facts.model = "central-generic";
  budget.facts.noncentral_tried = true;
  EXPECT_EQ(JudgeBudget(budget).limit, "unexplained");
  EXPECT_EQ(JudgeBudget(budget).advice, "try --knot-spacing-px auto");
  budget.facts.cells_chosen = budget.facts.tried_finer = true;
  EXPECT_NE(JudgeBudget(budget).advice.find("are no better; look for blur"),
            std::string::npos);
}

// A webcam's scene: a small board, rows that are taken one after the other
// while the camera moves. No model helps.
TEST(JudgeBudget, IsTheVerdictOfACalibration) {
  SimulationOptions simulation;
  simulation.num_images = 30;
  simulation.features_per_image = 36;
  simulation.noise_px = 0.1;
  simulation.seed = 2;  // four of eight draws separate row from column time
  const Pattern pattern = ChessboardPattern(6, 6, 0.0254);
  CalibrationOptions options;
  options.cell_px = 320;
  options.rigid_board = true;
  options.num_threads = 2;
  const auto camera = SimulatedLens("wide", {1280, 720});
  const Dataset seen = SimulateFaultyObservations(*camera, pattern, simulation,
                                                  SimulatedFault::kRowTime, 2);
  for (int i = 0; i < 6; ++i)
    options.hold_out.push_back(seen.images[5 * i].image);
  const CalibrationResult result = Calibrate(seen, pattern, options);
  ASSERT_TRUE(result.budget.has_value());
  const BudgetVerdict limit = JudgeBudget(*result.budget);
  EXPECT_EQ(limit.limit, "rolling shutter");
  std::string reasons;
  for (const std::string& reason : result.verdict.reasons)
    reasons += reason + "\n";
  EXPECT_NE(reasons.find(limit.sentence + "; " + limit.advice),
            std::string::npos)
      << reasons;
  for (const char* other : {"--model", "--knot-spacing-px", "flatter", "blur"})
    EXPECT_EQ(reasons.find(other), std::string::npos) << reasons;
}

}  // namespace
}  // namespace raygrid
