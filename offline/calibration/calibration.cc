#include "calibration/calibration.h"

#include <algorithm>
#include <utility>

#include "calibration/calibration_steps.h"
#include "calibration/input_checks.h"
#include "camera/model_registry.h"

namespace raygrid {

std::vector<std::string> ListCalibratedModels() {
  std::vector<std::string> names =
      ListModelNames(ModelUse::kCalibrate,
                     {models::kNonCentralGeneric, models::kCentralGeneric});
  std::reverse(names.begin(), names.end());
  return names;
}

RigResult Calibrate(const std::vector<CalibrationInput>& cameras,
                    const Pattern& pattern, const CalibrationOptions& options) {
  RequireValidInput(cameras, pattern, options);
  Calibration calibration(cameras, pattern, options);
  calibration.Start();
  calibration.RefineFeatures();
  calibration.RotateBoards();
  calibration.CompensateRollingShutter();
  calibration.SelectKnotSpacings();
  calibration.OptimizeCameras();
  calibration.EvaluateHeldOutImages();
  calibration.RestartFromFolds();
  calibration.EstimateLineDelays();
  calibration.CompareWithOthers();
  return calibration.Assess();
}

CalibrationResult Calibrate(const Dataset& dataset, const Pattern& pattern,
                            const CalibrationOptions& options) {
  return std::move(Calibrate({CalibrationInput{"", dataset}}, pattern, options)
                       .cameras.front());
}

}  // namespace raygrid
