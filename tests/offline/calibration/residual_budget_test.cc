#include "evaluation/residual_budget.h"

#include <string>

#include "calibration/budget_input.h"
#include "calibration/calibration.h"
#include "evaluation/budget_assessment.h"
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
  const auto camera = MakeSimulatedCamera("example", {640, 480});
  const Pattern pattern = ChessboardPattern(17, 11, 0.024);
  return MakeBudgetInput(
      *camera, SimulateFaultyObservations(*camera, pattern, options, fault),
      pattern, 2);
}

ResidualBudget BudgetWith(SimulatedFault fault, uint64_t seed) {
  return ComputeResidualBudget(InputWith(fault, BudgetSimulation(seed)));
}

// An error of each axis is taken by a pose: 6 of 240 numbers.
TEST(ResidualBudget, NoiseAloneIsNoise) {
  for (const uint64_t seed : {1, 2, 3, 4, 5}) {
    const ResidualBudget budget = BudgetWith(SimulatedFault::kNone, seed);
    ASSERT_EQ(budget.unobservable_reason, "");
    EXPECT_NEAR(budget.noise_px.x(), kBudgetNoisePx, 0.05 * kBudgetNoisePx);
    EXPECT_NEAR(budget.noise_px.y(), kBudgetNoisePx, 0.05 * kBudgetNoisePx);
    EXPECT_NEAR(budget.noise, 1, 0.05);
    EXPECT_NEAR(budget.rest, 0, 0.05);
    EXPECT_LT(budget.large, 0.001);
    for (const CauseShare& share : budget.causes) {
      ASSERT_TRUE(share.is_observable);
      EXPECT_EQ(share.sequential_share, 0);
      EXPECT_LE(share.alone, std::max(share.random_limit, 0.002));
      EXPECT_LT(share.random_limit, 0.01);
    }
    EXPECT_EQ(AssessBudget(budget).limit, "noise");
  }
}

// A pose takes up a scale of a pinhole's image. What is left of it may not be
// the noise that pixels have.
TEST(ResidualBudget, NoiseOfAPinholeIsNoise) {
  for (const uint64_t seed : {1, 2, 3}) {
    SimulationOptions options = BudgetSimulation(seed);
    options.features_per_image = 48;
    const auto camera = MakeSimulatedCamera("pinhole", {640, 480});
    const Pattern pattern = ChessboardPattern(8, 6, 0.025);
    const ResidualBudget budget = ComputeResidualBudget(MakeBudgetInput(
        *camera, SimulateObservations(*camera, pattern, options).dataset,
        pattern, 2));
    EXPECT_EQ(AssessBudget(budget).limit, "noise") << seed;
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
          ComputeResidualBudget(InputWith(fault, options));
      EXPECT_EQ(AssessBudget(budget).limit, ToString(fault)) << seed;
      double sum = budget.noise + budget.large + budget.rest;
      for (int k = 0; k < kNumErrorCauses; ++k) {
        const CauseShare& share = budget.Of(static_cast<ErrorCause>(k));
        sum += share.sequential_share;
        if (k + 1 == f)
          EXPECT_GT(share.sequential_share, 0.4) << ToString(fault);
        else
          EXPECT_LT(share.sequential_share, 0.05) << ToString(fault);
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
      const BudgetAssessment assessment = AssessBudget(BudgetWith(fault, seed));
      EXPECT_TRUE(
          assessment.limit == ToString(fault) ||
          (assessment.limit == "per-view effects" &&
           assessment.sentence.find(ToString(fault)) != std::string::npos))
          << seed << " " << ToString(fault) << ": " << assessment.sentence;
    }
  }
}

TEST(ResidualBudget, NamesBendsOfACalibrationWithRigidBoards) {
  SimulationOptions simulation;
  simulation.num_images = 16;
  simulation.features_per_image = 130;
  simulation.noise_px = 0.02;
  simulation.board_deformation_m = 0.0004;
  CalibrationOptions options;
  options.knot_spacing_px = 160;
  options.rigid_board = true;
  options.num_threads = 2;
  CalibrationResult result = Calibrate(
      SimulateObservations(ExampleSimulatedCamera(), TestBoard(), simulation)
          .dataset,
      TestBoard(), options);
  ASSERT_TRUE(result.budget.has_value());
  ResidualBudget budget = *result.budget;
  EXPECT_EQ(AssessBudget(budget).limit, "per-view deformation");
  EXPECT_GT(budget.Of(ErrorCause::kDeformation).sequential_share, 0.4);
  // Only things that were not tried are advised.
  EXPECT_NE(AssessBudget(budget).advice.find("--rigid-target"),
            std::string::npos);
  budget.facts.has_tried_deformation = true;
  EXPECT_NE(AssessBudget(budget).advice.find("glass"), std::string::npos);
}

TEST(ResidualBudget, LargeErrorsDoNotHideTheNoise) {
  BudgetInput input = InputWith(SimulatedFault::kNone, BudgetSimulation(1));
  for (size_t i = 50; i < input.features.size(); i += 400)
    input.features[i].error_px += Eigen::Vector2d(2, -1);
  const ResidualBudget budget = ComputeResidualBudget(input);
  EXPECT_GT(budget.large, 0.3);
  EXPECT_NEAR(budget.noise_px.x(), kBudgetNoisePx, 0.1 * kBudgetNoisePx);
  EXPECT_EQ(AssessBudget(budget).limit, "outliers");
}

TEST(ResidualBudget, FewViewsDoNotTellPlaces) {
  SimulationOptions few = BudgetSimulation(1);
  few.num_images = 7;
  const ResidualBudget budget =
      ComputeResidualBudget(InputWith(SimulatedFault::kRollingShutter, few));
  EXPECT_FALSE(budget.Of(ErrorCause::kImagePosition).is_observable);
  EXPECT_EQ(budget.Of(ErrorCause::kBoardPosition).unobservable_reason,
            "7 views, at least 8 required");
  EXPECT_TRUE(budget.Of(ErrorCause::kRollingShutter).IsDetermined());
}

TEST(ResidualBudget, FewFeaturesDoNotTellViews) {
  BudgetInput input =
      InputWith(SimulatedFault::kDeformation, BudgetSimulation(1));
  std::vector<BudgetFeature> few;
  std::vector<int> count(40, 0);
  for (const BudgetFeature& feature : input.features)
    if (++count[feature.view] < 24) few.push_back(feature);
  input.features = few;
  const ResidualBudget budget = ComputeResidualBudget(input);
  EXPECT_FALSE(budget.Of(ErrorCause::kDeformation).is_observable);
  EXPECT_TRUE(budget.Of(ErrorCause::kImagePosition).is_observable);
  input.features.resize(150);
  const ResidualBudget nothing = ComputeResidualBudget(input);
  EXPECT_EQ(nothing.unobservable_reason, "150 features, at least 200 required");
  EXPECT_NE(AssessBudget(nothing).sentence.find("not observable"),
            std::string::npos);
}

TEST(ResidualBudget, ExactFeaturesHaveNoErrors) {
  BudgetInput input = InputWith(SimulatedFault::kNone, BudgetSimulation(1));
  for (BudgetFeature& feature : input.features) feature.error_px.setZero();
  EXPECT_EQ(ComputeResidualBudget(input).unobservable_reason,
            "all residuals are zero");
}

// A budget whose only cause is one.
ResidualBudget BudgetOf(ErrorCause cause, const BudgetSummary& facts) {
  ResidualBudget budget;
  budget.facts = facts;
  CauseShare& share = budget.causes[static_cast<size_t>(cause)];
  share.is_observable = true;
  share.sequential_share = share.alone = 0.5;
  budget.noise = 0.5;
  return budget;
}

TEST(AssessBudget, AdvisesNothingThatWasDone) {
  const auto advice = [](ErrorCause cause, const BudgetSummary& facts) {
    return AssessBudget(BudgetOf(cause, facts)).advice;
  };
  const auto has = [](const std::string& text, const char* word) {
    return text.find(word) != std::string::npos;
  };
  BudgetSummary facts;
  facts.model = "opencv";
  EXPECT_TRUE(
      has(advice(ErrorCause::kImagePosition, facts), "--model central"));
  EXPECT_TRUE(
      has(advice(ErrorCause::kBoardPosition, facts), "--fix-target-geometry"));
  facts.has_tried_generic_model = true;
  EXPECT_FALSE(has(advice(ErrorCause::kImagePosition, facts), "--model"));
  facts.model = "central-generic";
  facts.has_estimated_points = facts.has_tried_deformation = true;
  facts.knot_spacing_px = 80;
  EXPECT_TRUE(
      has(advice(ErrorCause::kImagePosition, facts), "--knot-spacing-px 40"));
  EXPECT_TRUE(has(advice(ErrorCause::kBoardPosition, facts), "print"));
  EXPECT_TRUE(has(advice(ErrorCause::kDeformation, facts), "glass"));
  facts.has_tried_finer_grid = true;
  EXPECT_TRUE(has(advice(ErrorCause::kImagePosition, facts), "add images"));
  EXPECT_FALSE(
      has(advice(ErrorCause::kImagePosition, facts), "--knot-spacing-px"));
  facts.better_model = "noncentral-generic";
  EXPECT_TRUE(has(advice(ErrorCause::kImagePosition, facts),
                  "--model noncentral-generic, which has a lower"));
  facts.mixed_cameras = true;
  EXPECT_TRUE(has(advice(ErrorCause::kImagePosition, facts), "two cameras"));
}

TEST(AssessBudget, NamesNoCauseThatAnotherExplainsAsWell) {
  ResidualBudget budget = BudgetOf(ErrorCause::kRollingShutter, {});
  EXPECT_EQ(AssessBudget(budget).limit, "rolling shutter");
  budget.causes[static_cast<size_t>(ErrorCause::kRollingShutter)]
      .is_indistinguishable = true;
  EXPECT_EQ(AssessBudget(budget).limit, "rolling shutter");
  budget.is_column_delay_indistinguishable = true;
  EXPECT_EQ(AssessBudget(budget).limit, "per-view effects");
  EXPECT_NE(AssessBudget(budget).sentence.find("candidates: rolling shutter"),
            std::string::npos);
  // The model may be to blame where no cause is.
  budget.facts.model = "opencv";
  EXPECT_NE(
      AssessBudget(budget).advice.find("first use --model central-generic"),
      std::string::npos);
  budget.facts.has_tried_generic_model = true;
  EXPECT_EQ(AssessBudget(budget).advice.find("--model"), std::string::npos);
  budget.facts.model = "central-generic";
  budget.facts.has_estimated_points = false;
  EXPECT_NE(AssessBudget(budget).advice.find(
                "first calibrate without --fix-target-geometry"),
            std::string::npos);
  budget.facts.has_estimated_points = true;
  EXPECT_NE(
      AssessBudget(budget).advice.find("first use --model noncentral-generic"),
      std::string::npos);
  budget.facts.has_tried_noncentral_model = true;
  EXPECT_EQ(AssessBudget(budget).advice.find("--model"), std::string::npos);
  budget.facts.better_model = "noncentral-generic";
  EXPECT_NE(AssessBudget(budget).advice.find(
                "--model noncentral-generic, which has a lower"),
            std::string::npos);
}

// A cause that is not told says of errors that neighbours share what the
// verdict does.
TEST(AssessBudget, AdvisesOfTheRestWhatTheVerdictDoes) {
  ResidualBudget budget;
  budget.noise = 0.3;
  budget.rest = 0.7;
  budget.facts.model = "central-generic";
  budget.facts.has_tried_noncentral_model = true;
  EXPECT_EQ(AssessBudget(budget).limit, "unexplained");
  EXPECT_EQ(AssessBudget(budget).advice, "try --knot-spacing-px auto");
  budget.facts.knot_spacing_selected = budget.facts.has_tried_finer_grid = true;
  EXPECT_NE(AssessBudget(budget).advice.find("are no better; look for blur"),
            std::string::npos);
}

// A webcam's scene: a small board, rows that are taken one after the other
// while the camera moves. No model helps.
TEST(AssessBudget, IsTheVerdictOfACalibration) {
  SimulationOptions simulation;
  simulation.num_images = 30;
  simulation.features_per_image = 36;
  simulation.noise_px = 0.1;
  simulation.seed = 2;  // four of eight draws separate row from column time
  const Pattern pattern = ChessboardPattern(6, 6, 0.0254);
  CalibrationOptions options;
  options.knot_spacing_px = 320;
  options.rigid_board = true;
  options.num_threads = 2;
  const auto camera = MakeSimulatedCamera("wide", {1280, 720});
  const Dataset seen = SimulateFaultyObservations(
      *camera, pattern, simulation, SimulatedFault::kRollingShutter, 2);
  for (int i = 0; i < 6; ++i)
    options.hold_out.push_back(seen.images[5 * i].image);
  const CalibrationResult result = Calibrate(seen, pattern, options);
  ASSERT_TRUE(result.budget.has_value());
  const BudgetAssessment limit = AssessBudget(*result.budget);
  EXPECT_EQ(limit.limit, "rolling shutter");
  std::string reasons;
  for (const std::string& reason : result.assessment.reasons)
    reasons += reason + "\n";
  EXPECT_NE(reasons.find(limit.sentence + "; " + limit.advice),
            std::string::npos)
      << reasons;
  for (const char* other : {"--model", "--knot-spacing-px", "flatter", "blur"})
    EXPECT_EQ(reasons.find(other), std::string::npos) << reasons;
}

}  // namespace
}  // namespace raygrid
