#ifndef RAYGRID_CALIBRATION_CAMERA_ADJUSTMENT_H
#define RAYGRID_CALIBRATION_CAMERA_ADJUSTMENT_H

#include <memory>
#include <string>
#include <vector>

#include "adjustment/bundle_adjustment.h"
#include "calibration/calibration_problem.h"
#include "camera/central_generic.h"

namespace raygrid {

using CameraModels = std::vector<std::unique_ptr<CameraModel>>;

CameraModels CopyCameras(const AdjustmentState& state);
bool AreParametric(const CameraModels& lenses);

/// The options with fixed points, and with no more steps than it takes to learn
/// the prior.
AdjustmentOptions MakeInitializationOptions(AdjustmentOptions options);

/// Infinite residuals, of features that are not projected, count.
double ComputeMedianErrorPx(const std::vector<Residual>& residuals);

/// The cameras that an adjustment starts from, or that grids lie around, and
/// the grids' cells.
struct InitialValues {
  const CameraModels& lenses;
  const std::vector<double>& knot_spacings_px;
  const std::vector<BaseModel>& bases;  ///< empty: of no parametric model
  /// Grids of other knot spacings, adjusted to the same images: a warm start.
  const AdjustmentResult* adjusted = nullptr;

  BaseModel GetBaseModel(size_t camera) const {
    return bases.empty() ? BaseModel() : bases[camera];
  }
};

/// A grid that starts as a camera's lens.
CentralGeneric MakeInitialGrid(const CalibrationProblem& problem, size_t camera,
                               const InitialValues& starts);

/// The mean distance of the points that a camera sees, metres.
double ComputeMeanDistance(const CalibrationProblem& problem, size_t camera,
                           const AdjustmentState& state);

/// Adjusts parametric cameras of a model, from lenses of any model. *prior is
/// as it was learned.
AdjustmentSummary OptimizeParametricCameras(const std::string& model,
                                            const CalibrationProblem& problem,
                                            const CameraModels& lenses,
                                            const AdjustmentOptions& options,
                                            GaussianPrior* prior,
                                            AdjustmentState* state);

/// Adjusts central grids, each around a lens.
AdjustmentSummary OptimizeGrids(const CalibrationProblem& problem,
                                const InitialValues& starts,
                                const AdjustmentOptions& options,
                                GaussianPrior* prior, AdjustmentState* state);

/// Adjusts cameras of any model.
AdjustmentSummary OptimizeCameras(const std::string& model,
                                  const CalibrationProblem& problem,
                                  const InitialValues& starts,
                                  const AdjustmentOptions& options,
                                  GaussianPrior* prior, AdjustmentState* state);

/// Adjusts cameras from where the state is: parametric ones, or grids, which
/// scatter smoothly around where they are.
AdjustmentSummary RefineCameras(const CalibrationProblem& problem,
                                const AdjustmentOptions& options,
                                AdjustmentState* state);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_ADJUSTMENT_H
