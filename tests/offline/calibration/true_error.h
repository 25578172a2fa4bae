#ifndef RAYGRID_TESTS_OFFLINE_CALIBRATION_TRUE_ERROR_H
#define RAYGRID_TESTS_OFFLINE_CALIBRATION_TRUE_ERROR_H

#include <string>

#include "calibration/calibration.h"
#include "evaluation/model_difference.h"
#include "oracle.h"

namespace raygrid {

/// A simulation to measure the error of a calibration by.
struct TrueErrorSetting {
  std::string lens = "wide";    ///< as LensFamilyOf() names them
  std::string target = "flat";  ///< or "bent", or "bending" from view to view
  int num_images = 40;
  double noise_px = 0.05;
  double cell_px = 20;  ///< 0: chosen by the calibration
};

/// Errors of a camera's rays, px, after the best rotation.
struct TrueError {
  double rms_px = 0, median_px = 0, max_px = 0;
  double oracle_px = 0;  ///< the RMS of the best possible estimate
};

/// Calibrates a lens that the seed draws.
inline TrueError MeasureTrueError(const TrueErrorSetting& setting,
                                  uint64_t seed) {
  constexpr double kStepPx = 10;
  const LensFamily family = LensFamilyOf(setting.lens);
  const std::unique_ptr<CameraModel> truth = DrawLens(family, seed);
  SimulationOptions simulation;
  simulation.num_images = setting.num_images;
  simulation.noise_px = setting.noise_px;
  simulation.seed = seed;
  if (setting.target == "bent") simulation.board_bend_m = 0.002;
  if (setting.target == "bending") simulation.board_flex_m = 0.0003;
  const Pattern pattern = ChessboardPattern(25, 17, 0.015);
  const SimulatedObservations simulated =
      SimulateObservations(*truth, pattern, simulation);
  CalibrationOptions options;
  options.cell_px = setting.cell_px;
  options.flat_board = setting.target == "flat";
  // Without folds to evaluate.
  options.hold_out = {simulated.dataset.images.back().image};
  options.num_threads = 1;
  const CalibrationResult result =
      Calibrate(simulated.dataset, pattern, options);
  const ModelDifference difference =
      CompareModels(*truth, *result.camera.camera, kStepPx);
  return {difference.rms_px, difference.median_px, difference.max_px,
          OracleRmsPx(family, *truth, simulated, setting.noise_px)};
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_CALIBRATION_TRUE_ERROR_H
