#ifndef RAYGRID_CALIBRATION_CAMERA_ADJUSTMENT_H
#define RAYGRID_CALIBRATION_CAMERA_ADJUSTMENT_H

#include <memory>
#include <string>
#include <vector>

#include "adjustment/bundle_adjustment.h"
#include "calibration/calibration_problem.h"
#include "camera/central_generic.h"

namespace raygrid {

using Lenses = std::vector<std::unique_ptr<CameraModel>>;

Lenses CopyCameras(const AdjustmentState& state);
bool AreParametric(const Lenses& lenses);

/// The options with fixed points, and with no more steps than it takes to learn
/// the prior.
AdjustmentOptions AsStart(AdjustmentOptions options);

/// Infinite residuals, of features that are not projected, count.
double MedianErrorPx(const std::vector<Residual>& residuals);

/// The cameras that an adjustment starts from, or that grids lie around, and
/// the grids' cells.
struct Starts {
  const Lenses& lenses;
  const std::vector<double>& cells_px;
  const std::vector<BaseLens>& bases;  ///< empty: of no parametric model
  /// Grids of other knot spacings, adjusted to the same images: a warm start.
  const Adjusted* adjusted = nullptr;

  BaseLens BaseOf(size_t camera) const {
    return bases.empty() ? BaseLens() : bases[camera];
  }
};

/// A grid that starts as a camera's lens.
CentralGeneric AsGrid(const CalibrationProblem& problem, size_t camera,
                      const Starts& starts);

/// The mean distance of the points that a camera sees, metres.
double MeanDistance(const CalibrationProblem& problem, size_t camera,
                    const AdjustmentState& state);

/// Adjusts parametric cameras of a model, from lenses of any model. *prior is
/// as it was learned.
AdjustmentSummary AdjustLenses(const std::string& model,
                               const CalibrationProblem& problem,
                               const Lenses& lenses,
                               const AdjustmentOptions& options,
                               GaussianPrior* prior, AdjustmentState* state);

/// Adjusts central grids, each around a lens.
AdjustmentSummary AdjustGrids(const CalibrationProblem& problem,
                              const Starts& starts,
                              const AdjustmentOptions& options,
                              GaussianPrior* prior, AdjustmentState* state);

/// Adjusts cameras of any model.
AdjustmentSummary Adjust(const std::string& model,
                         const CalibrationProblem& problem,
                         const Starts& starts, const AdjustmentOptions& options,
                         GaussianPrior* prior, AdjustmentState* state);

/// Adjusts cameras from where the state is: parametric ones, or grids, which
/// scatter smoothly around where they are.
AdjustmentSummary AdjustCameras(const CalibrationProblem& problem,
                                const AdjustmentOptions& options,
                                AdjustmentState* state);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_ADJUSTMENT_H
