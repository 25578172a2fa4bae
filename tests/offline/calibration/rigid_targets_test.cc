// Boards that are fixed to each other, with known truth.

#include <algorithm>
#include <cmath>

#include "calibration/calibration.h"
#include "dataset/error.h"
#include "evaluation/model_difference.h"
#include "evaluation/rigid_target_text.h"
#include "simulation/simulated_rig.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr double kGapM = 0.25, kBaselineM = 1;

Pattern SeveralBoards(int count) {
  Pattern pattern = ChessboardPattern(8, 6, 0.025);
  for (int id = 1; id < count; ++id) {
    pattern.boards.push_back(pattern.boards.front());
    pattern.boards.back().id = id;
  }
  return pattern;
}

SimulationOptions Views(int count, uint64_t seed) {
  SimulationOptions options;
  options.num_images = count;
  options.noise_px = 0.05;
  options.seed = seed;
  return options;
}

FixedBoards FarApart() {
  FixedBoards fixed;
  fixed.gap_m = kGapM;
  return fixed;
}

SimulatedRig Row(int num_cameras) {
  return MakeCameraRow(std::make_shared<OpenCvModel>(ExampleLens()),
                       num_cameras, kBaselineM);
}

// Two cameras that never see one board together.
SimulatedRigObservations WithoutSharedBoards(uint64_t seed) {
  FixedBoards fixed = FarApart();
  fixed.without_shared_views = true;
  return SimulateRig(Row(2), SeveralBoards(3), fixed, Views(60, seed));
}

std::vector<CalibrationInput> CamerasOf(const SimulatedRigObservations& seen) {
  std::vector<CalibrationInput> inputs;
  for (size_t c = 0; c < seen.datasets.size(); ++c)
    inputs.push_back({"cam" + std::to_string(c), seen.datasets[c]});
  return inputs;
}

// Parametric, with one image held out: cross-validation takes most of the time.
CalibrationOptions WithoutValidation() {
  CalibrationOptions options;
  options.model = "opencv";
  options.num_threads = 2;
  options.hold_out = {"sim0000.png"};
  return options;
}

// A board's pose in the frame of another one, by two poses in one image.
Pose TrueRelation(const SimulatedRigObservations& seen, int first, int second) {
  for (const std::vector<BoardPose>& poses : seen.poses)
    for (const BoardPose& a : poses)
      for (const BoardPose& b : poses)
        if (a.board == first && b.board == second && a.image == b.image)
          return a.camera_from_board.Inverse() * b.camera_from_board;
  throw Error(ExitCode::kInsufficientData,
              "the boards are never seen together");
}

bool IsFixed(const RigResult& result, int first, int second) {
  for (const BoardPair& pair : result.board_pairs)
    if (pair.first == first && pair.second == second) return pair.fixed;
  throw Error(ExitCode::kInsufficientData, "nothing is known of the boards");
}

TEST(CalibrateRigidTargets, ConnectCamerasThatNeverSeeOneBoardTogether) {
  for (const uint64_t seed : {1, 2, 3}) {
    const SimulatedRigObservations seen = WithoutSharedBoards(seed);
    const RigResult result =
        Calibrate(CamerasOf(seen), seen.true_pattern, WithoutValidation());
    ASSERT_EQ(result.rigid_targets.size(), 1u);
    EXPECT_EQ(result.rigid_targets[0].boards, (std::vector<int>{0, 1, 2}))
        << "seed " << seed << ": "
        << DescribeRigidTargets(result.rigid_targets, result.board_pairs)
               .back();
    const Baseline& baseline = result.baselines.front();
    ASSERT_TRUE(baseline.distance_stddev_m);
    EXPECT_LT(std::abs(baseline.distance_m - kBaselineM),
              3 * *baseline.distance_stddev_m);
    EXPECT_LT(*baseline.distance_stddev_m, 1e-3);
    EXPECT_GT(baseline.num_shared_views, 3);
    for (int board = 1; board < 3; ++board) {
      const Pose truth = TrueRelation(seen, 0, board);
      const Pose& found = result.rigid_targets[0].first_from_board[board];
      EXPECT_LT((found.translation - truth.translation).norm(), 1e-3);
      EXPECT_LT(found.rotation.angularDistance(truth.rotation), 2e-3);
    }
  }
}

TEST(CalibrateRigidTargets, AreForbiddenByAnOption) {
  const SimulatedRigObservations seen = WithoutSharedBoards(1);
  CalibrationOptions options = WithoutValidation();
  options.independent_boards = true;
  try {
    Calibrate(CamerasOf(seen), seen.true_pattern, options);
    ADD_FAILURE() << "the cameras were connected";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInitializationFailed);
    EXPECT_TRUE(std::string(error.what()).find("not connected") !=
                std::string::npos)
        << error.what();
  }
}

TEST(CalibrateRigidTargets, AreThoseBoardsThatWereNotMoved) {
  FixedBoards fixed = FarApart();
  fixed.gap_m = 0.05;
  fixed.move_m = 0.01;
  const SimulatedRigObservations seen =
      SimulateRig(Row(1), SeveralBoards(3), fixed, Views(40, 1));
  const RigResult result =
      Calibrate(CamerasOf(seen), seen.true_pattern, WithoutValidation());
  ASSERT_EQ(result.rigid_targets.size(), 1u);
  EXPECT_EQ(result.rigid_targets[0].boards, (std::vector<int>{0, 1}));
  EXPECT_TRUE(IsFixed(result, 0, 1));
  EXPECT_FALSE(IsFixed(result, 0, 2));
  EXPECT_FALSE(IsFixed(result, 1, 2));
  const auto told =
      DescribeRigidTargets(result.rigid_targets, result.board_pairs);
  ASSERT_EQ(told.size(), 2u);
  EXPECT_EQ(told[0].find("boards 0 and 1 are a rigid multi-board target"), 0u)
      << told[0];
  EXPECT_EQ(told[1].find("boards 0, 1 and 2"), 0u) << told[1];
}

// Folds were started for the choice of bends, before the body was found.
TEST(CalibrateRigidTargets, OfOneCameraAreCrossValidated) {
  const SimulatedRigObservations seen =
      SimulateRig(Row(1), SeveralBoards(2), FarApart(), Views(12, 1));
  CalibrationOptions options;
  options.num_threads = 2;
  options.knot_spacing_px = 160;
  const RigResult result =
      Calibrate(CamerasOf(seen), seen.true_pattern, options);
  ASSERT_EQ(result.rigid_targets.size(), 1u);
  const CalibrationResult& camera = result.cameras.front();
  EXPECT_TRUE(camera.cross_validated);
  EXPECT_EQ(camera.held_out.size(), camera.training.size());
}

TEST(CalibrateRigidTargets, AreNoneWhereBoardsMove) {
  const SimulatedRigObservations seen =
      SimulateRig(Row(1), SeveralBoards(2), Views(30, 1));
  CalibrationOptions options = WithoutValidation();
  const RigResult free = Calibrate(CamerasOf(seen), seen.true_pattern, options);
  options.independent_boards = true;
  const RigResult moving =
      Calibrate(CamerasOf(seen), seen.true_pattern, options);
  EXPECT_TRUE(free.rigid_targets.empty());
  EXPECT_TRUE(moving.board_pairs.empty());
  EXPECT_EQ(free.cameras[0].camera.camera->Parameters(),
            moving.cameras[0].camera.camera->Parameters());
}

TEST(CalibrateRigidTargets, LeaveOutABoardThatIsHardlySeen) {
  FixedBoards fixed = FarApart();
  fixed.gap_m = 0.05;
  SimulatedRigObservations seen =
      SimulateRig(Row(1), SeveralBoards(3), fixed, Views(30, 2));
  bool is_first = true;
  for (ImageFeatures& image : seen.datasets[0].images) {
    auto& features = image.features;
    const auto is_last = [](const Feature& f) { return f.board == 2; };
    if (std::none_of(features.begin(), features.end(), is_last)) continue;
    if (!is_first)
      features.erase(std::remove_if(features.begin(), features.end(), is_last),
                     features.end());
    is_first = false;
  }
  const RigResult result =
      Calibrate(CamerasOf(seen), seen.true_pattern, WithoutValidation());
  ASSERT_EQ(result.rigid_targets.size(), 1u);
  EXPECT_EQ(result.rigid_targets[0].boards, (std::vector<int>{0, 1}));
}

TEST(CalibrateRigidTargets, AreFoundInExactFeatures) {
  FixedBoards fixed;
  SimulationOptions exact = Views(20, 1);
  exact.noise_px = 0;
  const SimulatedRigObservations seen =
      SimulateRig(Row(1), SeveralBoards(2), fixed, exact);
  const RigResult result =
      Calibrate(CamerasOf(seen), seen.true_pattern, WithoutValidation());
  EXPECT_EQ(result.rigid_targets.size(), 1u);
}

// A camera gains what a body knows beyond its boards.
TEST(CalibrateRigidTargets, MakeACameraMoreAccurate) {
  double squares[2] = {};
  for (const uint64_t seed : {1, 2, 3, 4}) {
    FixedBoards fixed;
    fixed.gap_m = 0.05;
    const SimulatedRig rig = Row(1);
    const SimulatedRigObservations seen =
        SimulateRig(rig, SeveralBoards(2), fixed, Views(16, seed));
    for (const bool independent_boards : {false, true}) {
      CalibrationOptions options = WithoutValidation();
      options.independent_boards = independent_boards;
      const RigResult result =
          Calibrate(CamerasOf(seen), seen.true_pattern, options);
      EXPECT_EQ(result.rigid_targets.empty(), independent_boards);
      const double error_px =
          CompareModels(*rig.cameras[0], *result.cameras[0].camera.camera, 25)
              .median_px;
      squares[independent_boards] += error_px * error_px;
    }
  }
  EXPECT_LT(squares[false], squares[true]);
}

}  // namespace
}  // namespace raygrid
