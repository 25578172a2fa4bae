// Boards that look alike after a turn are numbered alike in all images.

#include "calibration/board_rotations.h"

#include <algorithm>
#include <cmath>

#include "calibration/calibration.h"
#include "calibration/operating_point_calibration.h"
#include "evaluation/model_difference.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"
#include "simulation/simulated_rig.h"
#include "support.h"

namespace raygrid {
namespace {

Board Chessboard(int columns, int rows) {
  return ChessboardPattern(columns, rows, 0.03).boards[0];
}

bool IsBlackSquare(int column, int row) { return (column + row) % 2 == 0; }

// Whether the squares around a board's corners look as before after a turn.
bool LooksAlike(const Board& board, int turn) {
  for (int row = 0; row <= board.rows; ++row)
    for (int column = 0; column <= board.columns; ++column) {
      // Squares are turned as the corners of a board one larger would be.
      Board squares = Chessboard(board.columns, board.rows);
      const Pose pose = ComputeRotation(squares, turn);
      const Eigen::Vector3d center =
          pose * (0.03 * Eigen::Vector3d(column - 0.5, row - 0.5, 0));
      const int c = static_cast<int>(std::lround(center.x() / 0.03 + 0.5));
      const int r = static_cast<int>(std::lround(center.y() / 0.03 + 0.5));
      if (c < 0 || r < 0 || c > board.columns || r > board.rows ||
          IsBlackSquare(c, r) != IsBlackSquare(column, row))
        return false;
    }
  return true;
}

TEST(BoardRotations, AreThoseThatLookAlike) {
  EXPECT_EQ(Chessboard(7, 5).NumRotations(), 2);
  EXPECT_EQ(Chessboard(8, 6).NumRotations(), 2);
  EXPECT_EQ(Chessboard(7, 7).NumRotations(), 2);
  EXPECT_EQ(Chessboard(6, 6).NumRotations(), 4);
  EXPECT_EQ(Chessboard(9, 6).NumRotations(), 1);
  for (const char* kind : {"charuco", "star", "aprilgrid", "points"}) {
    Board board = Chessboard(7, 5);
    board.kind = kind;
    EXPECT_EQ(board.NumRotations(), 1) << kind;
  }
  for (int columns = 3; columns < 9; ++columns)
    for (int rows = 3; rows < 9; ++rows) {
      const Board board = Chessboard(columns, rows);
      for (int turn = 0; turn < board.NumRotations(); ++turn)
        EXPECT_TRUE(LooksAlike(board, turn)) << columns << " " << rows;
    }
}

TEST(BoardRotations, BringPointsToWhereFeaturesBecome) {
  for (const Board& board : {Chessboard(7, 5), Chessboard(6, 6)})
    for (int turn = 0; turn < board.NumRotations(); ++turn)
      for (int row = 0; row < board.rows; ++row)
        for (int column = 0; column < board.columns; ++column) {
          const auto [c, r] = board.Rotated(column, row, turn);
          EXPECT_LT((ComputeRotation(board, turn) *
                         board.points[board.PointIndex(column, row)] -
                     board.points[board.PointIndex(c, r)])
                        .norm(),
                    1e-12);
        }
}

// Each view of a board in turn by one of its turns.
BoardRotations RandomRotations(const Dataset& dataset, const Pattern& pattern,
                               uint64_t seed) {
  Random random(seed);
  BoardRotations turns;
  for (const ImageFeatures& image : dataset.images)
    for (const Board& board : pattern.boards) {
      const int turn =
          static_cast<int>(random.Uniform(0, board.NumRotations()));
      if (turn > 0) turns[{image.image, board.id}] = turn;
    }
  return turns;
}

// ---- One camera ------------------------------------------------------------

// A print whose points are some tenths of a millimetre off.
Pattern Misprinted(const Pattern& pattern, double off_m) {
  Pattern printed = pattern;
  Random random(5);
  for (Eigen::Vector3d& point : printed.boards[0].points)
    point += Eigen::Vector3d(random.Uniform(-off_m, off_m),
                             random.Uniform(-off_m, off_m), 0);
  return printed;
}

struct TurnedViews {
  Pattern nominal;
  Dataset upright, turned;
};

TurnedViews ViewsOf(const Pattern& nominal, double off_m, int num_images,
                    uint64_t seed) {
  SimulationOptions simulation;
  simulation.num_images = num_images;
  simulation.noise_px = 0.02;
  simulation.seed = seed;
  const Board& board = nominal.boards[0];
  simulation.features_per_image = board.num_points();
  TurnedViews views = {nominal, {}, {}};
  views.upright = SimulateObservations(ExampleLens(),
                                       Misprinted(nominal, off_m), simulation)
                      .dataset;
  views.turned = Rotated(views.upright, nominal,
                         RandomRotations(views.upright, nominal, seed + 1));
  return views;
}

double ErrorPx(const Dataset& dataset, const Pattern& pattern) {
  CalibrationOptions options;
  options.knot_spacing_px = 160;
  options.num_threads = 2;
  options.rigid_board = true;
  const CalibrationResult result = Calibrate(dataset, pattern, options);
  return CompareModels(ExampleLens(), *result.camera.camera, 20).rms_px;
}

TEST(CalibrateRotatedBoards, HasNoMoreErrorThanOfUprightOnes) {
  for (const Pattern& board :
       {ChessboardPattern(7, 5, 0.03), ChessboardPattern(6, 6, 0.03)}) {
    const TurnedViews views = ViewsOf(board, 0.0004, 20, 3);
    const double upright_px = ErrorPx(views.upright, board);
    EXPECT_LT(ErrorPx(views.turned, board), 1.2 * upright_px);
  }
}

// A calibration of a board that is as drawn does not depend on turns.
TEST(CalibrateRotatedBoards, TurnsNoneThatNothingTellsOf) {
  const TurnedViews views = ViewsOf(ChessboardPattern(7, 5, 0.03), 0, 12, 3);
  CalibrationOptions options;
  options.knot_spacing_px = 160;
  options.num_threads = 2;
  const CalibrationResult result =
      Calibrate(views.turned, views.nominal, options);
  EXPECT_TRUE(result.ambiguous_rotation_images.empty());
  for (const ImageFeatures& image : result.features.images) {
    const auto given = std::find_if(
        views.turned.images.begin(), views.turned.images.end(),
        [&](const auto& other) { return other.image == image.image; });
    for (const Feature& feature : image.features)
      EXPECT_TRUE(std::any_of(given->features.begin(), given->features.end(),
                              [&](const Feature& other) {
                                return other.column == feature.column &&
                                       other.row == feature.row &&
                                       other.pixel == feature.pixel;
                              }));
  }
}

// One image shows only nine corners of a print that is off by hundredths of a
// millimetre.
TEST(CalibrateRotatedBoards, NamesAViewThatDoesNotTellItsTurn) {
  TurnedViews views = ViewsOf(ChessboardPattern(13, 9, 0.03), 0.00005, 20, 3);
  ImageFeatures& poor = views.turned.images[4];
  std::vector<Feature> center;
  for (const Feature& f : poor.features)
    if (f.column >= 5 && f.column <= 7 && f.row >= 3 && f.row <= 5)
      center.push_back(f);
  poor.features = center;
  ASSERT_EQ(center.size(), 9u);
  CalibrationOptions options;
  options.knot_spacing_px = 160;
  options.num_threads = 2;
  options.rigid_board = true;
  const CalibrationResult result =
      Calibrate(views.turned, views.nominal, options);
  EXPECT_EQ(result.ambiguous_rotation_images,
            std::vector<std::string>{poor.image});
  EXPECT_TRUE(std::any_of(
      result.assessment.reasons.begin(), result.assessment.reasons.end(),
      [&](const std::string& reason) {
        return reason.find(
                   "orientation of the symmetric target is ambiguous") !=
                   std::string::npos &&
               reason.find(poor.image) != std::string::npos;
      }));
}

// ---- Operating points ------------------------------------------------------

// Images of a focusing lens, whose features are numbered by chance.
double StackErrorPx(bool is_turned) {
  const Pattern nominal = ChessboardPattern(7, 5, 0.03);
  ImageOperatingPoints conditions;
  conditions.conditions = {OperatingParameter::kLensPosition};
  CalibrationInput input;
  const ImageSize size = {640, 480};
  input.dataset.image_size = size;
  SimulationOptions simulation;
  simulation.num_images = 6;
  simulation.noise_px = 0.02;
  simulation.features_per_image = nominal.boards[0].num_points();
  for (const double value : {0.0, 2.5, 5.0, 7.5, 10.0}) {
    ++simulation.seed;
    const auto lens =
        MakeVaryingCamera(OperatingParameter::kLensPosition, value, size);
    for (ImageFeatures& image :
         SimulateObservations(*lens, Misprinted(nominal, 0.0004), simulation)
             .dataset.images) {
      image.image = std::to_string(simulation.seed) + image.image;
      conditions.values[image.image] = {value};
      input.dataset.images.push_back(std::move(image));
    }
  }
  if (is_turned)
    input.dataset = Rotated(input.dataset, nominal,
                            RandomRotations(input.dataset, nominal, 7));
  CalibrationOptions options;
  options.num_threads = 2;
  options.knot_spacing_px = 160;
  options.rigid_board = true;
  options.hold_out = {input.dataset.images.back().image};
  const OperatingPointCalibration stack =
      CalibrateOperatingPoints(input, conditions, nominal, options)
          .cameras[0]
          .camera.stack.value();
  return CompareModels(
             *MakeVaryingCamera(OperatingParameter::kLensPosition, 3.7, size),
             stack.cameras.At({3.7}), 20)
      .rms_px;
}

TEST(CalibrateRotatedBoards, HasNoMoreErrorOverOperatingPoints) {
  EXPECT_LT(StackErrorPx(true), 1.2 * StackErrorPx(false));
}

// ---- Rigs ------------------------------------------------------------------

SimulatedRigObservations StereoViews(const Pattern& pattern, int num_frames) {
  SimulationOptions simulation;
  simulation.num_images = num_frames;
  simulation.features_per_image = 140;
  simulation.noise_px = 0.05;
  return SimulateRig(
      MakeCameraRow(std::make_shared<OpenCvModel>(ExampleLens()), 3, 0.1),
      pattern, simulation);
}

RigResult CalibrateTurnedRig(const SimulatedRigObservations& seen,
                             const Pattern& pattern) {
  const char* names[] = {"left", "middle", "right"};
  std::vector<CalibrationInput> inputs;
  for (size_t c = 0; c < seen.datasets.size(); ++c)
    inputs.push_back(
        {names[c], Rotated(seen.datasets[c], pattern,
                           RandomRotations(seen.datasets[c], pattern, c + 1))});
  CalibrationOptions options;
  options.model = "opencv";
  options.num_threads = 2;
  options.hold_out = {seen.datasets[0].images[1].image};
  return Calibrate(inputs, pattern, options);
}

TEST(CalibrateRotatedBoards, FindsTheBaselinesOfARig) {
  for (const Pattern& board :
       {ChessboardPattern(13, 9, 0.03), ChessboardPattern(10, 10, 0.03)}) {
    const RigResult result = CalibrateTurnedRig(StereoViews(board, 10), board);
    ASSERT_EQ(result.baselines.size(), 3u);
    for (const Baseline& baseline : result.baselines) {
      EXPECT_NEAR(baseline.distance_m,
                  0.1 * static_cast<double>(baseline.second - baseline.first),
                  0.002);
      EXPECT_LT(baseline.angle_rad, 0.005);
    }
    EXPECT_TRUE(result.ambiguous_pairs.empty());
    EXPECT_LT(ComputeHeldOutMetrics(result)->median_px, 0.15);
  }
}

TEST(CalibrateRotatedBoards, SaysThatASingleSharedViewIsAmbiguous) {
  const Pattern board = ChessboardPattern(13, 9, 0.03);
  SimulatedRigObservations seen = StereoViews(board, 10);
  seen.datasets.resize(2);
  // Only one instant has a name in common.
  bool is_shared = false;
  for (ImageFeatures& image : seen.datasets[1].images) {
    const bool in_both = std::any_of(
        seen.datasets[0].images.begin(), seen.datasets[0].images.end(),
        [&](const auto& other) { return other.image == image.image; });
    if (!in_both) continue;
    if (is_shared) image.image = "own_" + image.image;
    is_shared = true;
  }
  ASSERT_TRUE(is_shared);
  const RigResult result = CalibrateTurnedRig(seen, board);
  ASSERT_EQ(result.ambiguous_pairs.size(), 1u);
  EXPECT_EQ(result.assessment.word, "warn");
  EXPECT_TRUE(std::any_of(
      result.assessment.reasons.begin(), result.assessment.reasons.end(),
      [](const std::string& reason) {
        return reason.find(
                   "left and middle: their relative pose is "
                   "ambiguous") == 0;
      }));
}

}  // namespace
}  // namespace raygrid
