#ifndef RAYGRID_CALIBRATION_ADJUSTMENT_RESULT_H
#define RAYGRID_CALIBRATION_ADJUSTMENT_RESULT_H

#include <vector>

#include "adjustment/bundle_adjustment.h"
#include "calibration/calibration_problem.h"

namespace raygrid {

/// A calibration without its figures.
struct AdjustmentResult {
  CalibrationProblem problem;
  AdjustmentState state;
  AdjustmentSummary summary;
  GaussianPrior prior;  ///< as it was learned
  /// The lenses that grids lie around, by camera; empty if they were not fitted
  /// to the features.
  std::vector<BaseModel> base_lenses;
  std::vector<RejectedImage> rejected_images;
  std::vector<std::vector<FeatureResidual>> rejected_features;  ///< by camera
};

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_ADJUSTMENT_RESULT_H
