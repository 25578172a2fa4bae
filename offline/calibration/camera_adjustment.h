#ifndef RAYGRID_CALIBRATION_CAMERA_ADJUSTMENT_H
#define RAYGRID_CALIBRATION_CAMERA_ADJUSTMENT_H

#include <memory>
#include <string>
#include <vector>

#include "adjustment/bundle_adjustment.h"
#include "calibration/adjustment_result.h"
#include "calibration/calibration_problem.h"
#include "camera/central_generic.h"

namespace raygrid {

using CameraModels = std::vector<std::unique_ptr<CameraModel>>;

CameraModels CopyCameras(const AdjustmentState& state);
bool AreParametric(const CameraModels& lenses);

/// Returns the options with fixed target points, and with only the iterations
/// needed to learn the prior.
AdjustmentOptions MakeInitializationOptions(AdjustmentOptions options);

/// Returns the median norm of the residuals. The residual of a feature without
/// a projection is infinite.
double ComputeMedianErrorPx(const std::vector<Residual>& residuals);

/// Initial values of an adjustment: cameras, knot spacings and base models.
struct InitialValues {
  const CameraModels& lenses;
  const std::vector<double>& knot_spacings_px;
  const std::vector<BaseModel>& bases;  ///< empty: no parametric base models
  /// Warm start of a central grid: the same images, optimized with central
  /// grids of another knot spacing.
  const AdjustmentResult* adjusted = nullptr;

  BaseModel GetBaseModel(size_t camera) const {
    return bases.empty() ? BaseModel() : bases[camera];
  }
};

/// Fits an initial grid to a camera's initial model.
CentralGeneric MakeInitialGrid(const CalibrationProblem& problem, size_t camera,
                               const InitialValues& starts);

/// Returns the mean distance of the points observed by a camera, in metres.
double ComputeMeanDistance(const CalibrationProblem& problem, size_t camera,
                           const AdjustmentState& state);

/// Optimizes parametric cameras of the given model, initialized from cameras of
/// any model. *prior receives the learned prior.
AdjustmentSummary OptimizeParametricCameras(const std::string& model,
                                            const CalibrationProblem& problem,
                                            const CameraModels& lenses,
                                            const AdjustmentOptions& options,
                                            GaussianPrior* prior,
                                            AdjustmentState* state);

/// Optimizes central grids, each initialized from a camera.
AdjustmentSummary OptimizeGrids(const CalibrationProblem& problem,
                                const InitialValues& starts,
                                const AdjustmentOptions& options,
                                GaussianPrior* prior, AdjustmentState* state);

/// Optimizes cameras of any model.
AdjustmentSummary OptimizeCameras(const std::string& model,
                                  const CalibrationProblem& problem,
                                  const InitialValues& starts,
                                  const AdjustmentOptions& options,
                                  GaussianPrior* prior, AdjustmentState* state);

/// Optimizes cameras from the current state: parametric cameras, or grids with
/// a smoothness prior centred on the current grid.
AdjustmentSummary RefineCameras(const CalibrationProblem& problem,
                                const AdjustmentOptions& options,
                                AdjustmentState* state);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_ADJUSTMENT_H
