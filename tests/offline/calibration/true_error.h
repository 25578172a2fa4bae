#ifndef RAYGRID_TESTS_OFFLINE_CALIBRATION_TRUE_ERROR_H
#define RAYGRID_TESTS_OFFLINE_CALIBRATION_TRUE_ERROR_H

#include <cmath>
#include <string>

#include "calibration/calibration.h"
#include "evaluation/model_difference.h"
#include "oracle.h"

namespace raygrid {

/// A simulation to measure the error of a calibration by.
struct TrueErrorSetting {
  std::string lens = "wide";  ///< as LensFamilyOf() names them
  /// Or "bent", or "bending" from view to view; or "correlated": flat, with
  /// noise of 0.05 px besides that is correlated over 8 features.
  std::string target = "flat";
  int num_images = 40;
  double noise_px = 0.05;
  double knot_spacing_px = 20;  ///< 0: chosen by the calibration
  bool with_oracle = true;
};

/// Errors of a camera's rays, px, after the best rotation.
struct TrueError {
  double rms_px = 0, median_px = 0, max_px = 0;
  double oracle_px = 0;  ///< the RMS of the best possible estimate
  /// Parts of the coordinates of all pixels whose error is within one and two
  /// stated standard deviations; RMS of the errors over the RMS stated.
  double within_1 = 0, within_2 = 0, ratio = 0;
  double trusted_within_1 = 0, trusted_within_2 = 0, trusted_ratio = 0;
  double valid_fraction = 0, jackknife_scale = 1;
};

/// Adds how far stated standard deviations hold.
inline void AddCoverage(const ModelDifference& difference,
                        const CalibrationResult& result, TrueError* error) {
  if (!result.camera.uncertainty) return;
  const CameraUncertainty& uncertainty = *result.camera.uncertainty;
  const Area& area = result.camera.camera->area();
  struct Sums {
    double count = 0, within_1 = 0, within_2 = 0, squares = 0, stated2 = 0;
  } sums[2];
  for (size_t i = 0; i < difference.pixels.size(); ++i) {
    const Eigen::Vector2d& pixel = difference.pixels[i];
    const double stated_px = uncertainty.lattice.At(area, pixel);
    if (!std::isfinite(stated_px)) continue;
    for (Sums* s : {&sums[0], &sums[1]}) {
      if (s == &sums[1] && !uncertainty.mask.IsValidAt(pixel)) continue;
      for (const double coordinate : difference.error_px[i]) {
        s->count += 1;
        s->within_1 += std::abs(coordinate) <= stated_px;
        s->within_2 += std::abs(coordinate) <= 2 * stated_px;
        s->squares += coordinate * coordinate;
        s->stated2 += stated_px * stated_px;
      }
    }
  }
  error->within_1 = sums[0].within_1 / sums[0].count;
  error->within_2 = sums[0].within_2 / sums[0].count;
  error->ratio = std::sqrt(sums[0].squares / sums[0].stated2);
  error->trusted_within_1 = sums[1].within_1 / sums[1].count;
  error->trusted_within_2 = sums[1].within_2 / sums[1].count;
  error->trusted_ratio = std::sqrt(sums[1].squares / sums[1].stated2);
  error->valid_fraction = sums[1].count / sums[0].count;
  error->jackknife_scale = uncertainty.jackknife_scale;
}

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
  if (setting.target == "bent") simulation.board_sagitta_m = 0.002;
  if (setting.target == "bending") simulation.board_deformation_m = 0.0003;
  if (setting.target == "correlated") simulation.shared_noise_px = 0.05;
  const Pattern pattern = ChessboardPattern(25, 17, 0.015);
  const SimulatedObservations simulated =
      SimulateObservations(*truth, pattern, simulation);
  CalibrationOptions options;
  options.knot_spacing_px = setting.knot_spacing_px;
  options.fix_target_geometry =
      setting.target == "flat" || setting.target == "correlated";
  // Without folds to evaluate.
  options.hold_out = {simulated.dataset.images.back().image};
  options.num_threads = 1;
  const CalibrationResult result =
      Calibrate(simulated.dataset, pattern, options);
  const ModelDifference difference =
      CompareModels(*truth, *result.camera.camera, kStepPx);
  TrueError error;
  error.rms_px = difference.rms_px;
  error.median_px = difference.median_px;
  error.max_px = difference.max_px;
  if (setting.with_oracle)
    error.oracle_px = OracleRmsPx(family, *truth, simulated, setting.noise_px);
  AddCoverage(difference, result, &error);
  return error;
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_CALIBRATION_TRUE_ERROR_H
