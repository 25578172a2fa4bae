// The frames that calibrations end in.

#include "calibration/frame_adjustment.h"

#include "calibration/calibration.h"
#include "camera/camera_frame.h"
#include "camera/model_fitting.h"
#include "simulation/simulated_rig.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

// Bent boards, few images: what a lens does not follow pulls at its axis.
SimulatedRigObservations SimulateInARow(const std::string& lens,
                                        int num_cameras) {
  SimulationOptions options;
  options.num_images = 6;
  options.features_per_image = 100;
  options.board_sagitta_m = 0.001;
  return SimulateRig(
      MakeCameraRow(MakeSimulatedCamera(lens, {640, 480}), num_cameras, 0.05),
      TwoTestBoards(), options);
}

CalibrationOptions CoarseOptionsOf(const std::string& model) {
  CalibrationOptions options;
  options.model = model;
  options.knot_spacing_px = 80;
  options.rigid_board = true;  // residuals are those of result.pattern then
  options.num_threads = 2;
  return options;
}

double FitTurnRad(const CameraModel& camera) {
  return ComputeCanonicalFrame(camera).AngleRad();
}

double AxisRad(const CameraModel& camera) {
  return std::acos(camera.Unproject(camera.area().center()).value().z());
}

// How far residuals are from those of the result's camera, poses and boards.
double ResidualChangePx(const CalibrationResult& result) {
  double change = 0;
  for (const FeatureResidual& residual : result.training) {
    const auto pose = std::find_if(
        result.poses.begin(), result.poses.end(), [&](const BoardPose& p) {
          return p.image == residual.image && p.board == residual.board;
        });
    const Board& board = *result.pattern.FindBoard(residual.board);
    const auto pixel = result.camera.camera->Project(
        pose->camera_from_board *
            board.points[board.PointIndex(residual.column, residual.row)],
        &residual.pixel, 10);
    change = std::max(
        change, (pixel.value() - residual.pixel - residual.error_px).norm());
  }
  return change;
}

void ExpectFrameOfTheNearestLens(const std::string& lens,
                                 const std::string& model) {
  const Dataset dataset = SimulateInARow(lens, 1).datasets.front();
  CalibrationOptions options = CoarseOptionsOf(model);
  options.hold_out = {dataset.images.front().image};
  const CalibrationResult result = Calibrate(dataset, TwoTestBoards(), options);
  const CameraModel& camera = *result.camera.camera;
  EXPECT_LT(FitTurnRad(camera), kMaxFrameRotationRad) << lens << " " << model;
  EXPECT_LT(AxisRad(camera), 2.5 * M_PI / 180) << lens << " " << model;
  EXPECT_LT(ResidualChangePx(result), 1e-9) << lens << " " << model;
}

TEST(CameraFrames, AreThoseOfTheNearestLens) {
  for (const std::string& model : ListCalibratedModels())
    ExpectFrameOfTheNearestLens("example", model);
  ExpectFrameOfTheNearestLens("wide", "central-generic");
  ExpectFrameOfTheNearestLens("glass", "noncentral-generic");
}

// Half of so coarse a grid's control points lie around the image, and might
// turn against the rest.
TEST(CameraFrames, OfCoarseGridsAreFoundToo) {
  SimulationOptions simulation;
  simulation.num_images = 19;
  simulation.features_per_image = 120;
  simulation.noise_px = 0.004;
  simulation.seed = 139;
  Pattern pattern = ChessboardPattern(18, 13, 0.02);
  pattern.boards.push_back(pattern.boards.front());
  pattern.boards.back().id = 1;
  const Dataset dataset =
      SimulateRig(
          MakeCameraRow(MakeSimulatedCamera("noncentral", {480, 640}), 1, 0),
          pattern, simulation)
          .datasets.front();
  CalibrationOptions options = CoarseOptionsOf("noncentral-generic");
  options.knot_spacing_px = 120;
  options.hold_out = {dataset.images.front().image};
  const CalibrationResult result = Calibrate(dataset, pattern, options);
  EXPECT_LT(FitTurnRad(*result.camera.camera), kMaxFrameRotationRad);
}

TEST(CameraFrames, OfRigsTurnRelativePosesToo) {
  const SimulatedRigObservations seen = SimulateInARow("example", 2);
  CalibrationOptions options = CoarseOptionsOf("central-generic");
  options.hold_out = {seen.datasets[0].images.front().image};
  const RigResult result = Calibrate(
      {{"a", seen.datasets[0], {}, {}}, {"b", seen.datasets[1], {}, {}}},
      TwoTestBoards(), options);
  EXPECT_LT(result.camera_from_rig[0].rotation.angularDistance(
                Eigen::Quaterniond::Identity()),
            1e-12);
  for (const CalibrationResult& camera : result.cameras) {
    EXPECT_LT(FitTurnRad(*camera.camera.camera), kMaxFrameRotationRad);
    EXPECT_LT(ResidualChangePx(camera), 1e-9);
  }
}

}  // namespace
}  // namespace raygrid
